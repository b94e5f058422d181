// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/wheeled_noise_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ekf/model/wheeled_noise.hpp"

namespace nacelle::ekf {
namespace {

constexpr const char* kWhich = "process_noise";
std::string limit(const char* name) { return std::string{"process_noise_limits."} + name; }

Problem refused(const std::string& parameter, std::string what, std::string way_out) {
  return {Place::of_parameter(parameter), std::move(what), std::move(way_out)};
}

}  // namespace

void declare_wheeled_noise(Node& node) {
  const VehicleLimits d;
  const auto say = [](const char* text) { return ParameterDescriptor{.description = text, .read_only = true}; };
  node.declare_parameter(kWhich, "robot_localization",
                         say("robot_localization: process_noise_covariance. wheeled: what follows from "
                             "process_noise_limits.*, for a vehicle on wheels."));
  node.declare_parameter(limit("linear_velocity"), d.speed_mps, say("The vehicle's highest speed, m/s."));
  node.declare_parameter(limit("linear_acceleration"), d.acceleration_mps2,
                         say("Its highest acceleration along its x axis, m/s^2."));
  node.declare_parameter(limit("angular_velocity"), d.yaw_rate_rps, say("Its highest yaw rate, rad/s."));
  node.declare_parameter(limit("angular_acceleration"), d.yaw_acceleration_rps2,
                         say("Its highest yaw acceleration, rad/s^2. 0: it reaches its yaw rate in the time in which "
                             "it reaches its speed."));
  node.declare_parameter(limit("interval"), 0.0,
                         say("Usual time between two measurements of the velocity, s. 0: 1/frequency. Give it for "
                             "inputs that are slower."));
}

Result<void, Problem> read_wheeled_noise(const Node& node, EkfOptions& options) {
  const auto which = node.get<std::string>(kWhich);
  if (which == "robot_localization") return {};
  if (which != "wheeled")
    return err(refused(kWhich, fmt::format("is '{}'", which), "give robot_localization or wheeled"));
  if (!node.get<std::vector<double>>("process_noise_covariance").empty()) {
    return err(refused("process_noise_covariance",
                       "is given beside process_noise: wheeled, which has a matrix of its own",
                       "leave one of them out"));
  }
  VehicleLimits limits;
  const std::pair<const char*, double*> positive[] = {{"linear_velocity", &limits.speed_mps},
                                                      {"linear_acceleration", &limits.acceleration_mps2},
                                                      {"angular_velocity", &limits.yaw_rate_rps}};
  for (const auto& [name, into] : positive) {
    *into = node.get<double>(limit(name));
    if (!(*into > 0.0) || !std::isfinite(*into))
      return err(refused(limit(name), fmt::format("is {}", *into), "give a positive number"));
  }
  limits.interval_s = 1.0 / options.frequency_hz;
  const std::pair<const char*, double*> or_zero[] = {{"angular_acceleration", &limits.yaw_acceleration_rps2},
                                                     {"interval", &limits.interval_s}};
  for (const auto& [name, into] : or_zero) {
    const auto value = node.get<double>(limit(name));
    if (!(value >= 0.0) || !std::isfinite(value))
      return err(refused(limit(name), fmt::format("is {}", value), "give 0 or more"));
    if (value > 0.0) *into = value;
  }
  limits.measures_acceleration = std::ranges::any_of(
      options.inputs, [](const InputOptions& input) { return (input.config & kAccelerationMask) != 0; });
  options.filter.process_noise = ProcessNoise{wheeled_process_noise(limits)};
  return {};
}

}  // namespace nacelle::ekf
