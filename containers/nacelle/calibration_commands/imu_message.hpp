// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "imu/model/wt901_units.hpp"

// Fields of messages as JSON. Errors: nlohmann's exceptions, for a message of another type.
namespace nacelle::cli {

/// Returns a geometry_msgs/Vector3 of a message.
[[nodiscard]] inline imu::Vector3 vector_in(const nlohmann::json& message, const char* field) {
  const nlohmann::json& v = message.at(field);
  return {v.at("x").get<double>(), v.at("y").get<double>(), v.at("z").get<double>()};
}

/// Returns header.stamp in s since the epoch of its clock.
[[nodiscard]] inline double stamp_s(const nlohmann::json& message) {
  const nlohmann::json& stamp = message.at("header").at("stamp");
  return stamp.at("sec").get<double>() + 1e-9 * stamp.at("nanosec").get<double>();
}

}  // namespace nacelle::cli
