// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>

#include "gps/model/error_model.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/node/device_watch.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::gps {

/// The parameters of the component; their names are nmea_navsat_driver's.
struct GpsOptions {
  std::string port = "/dev/ttyACM0";
  unsigned baud = 9600;
  std::string frame_id = "gps";
  std::string time_ref_source{};  ///< Empty: frame_id.
  std::array<double, 10> errors_m = kDefaultErrors_m;
  DeviceOptions device{};
  Duration port_timeout = 2s;   ///< With required_device: how long configure waits for the port to appear.
  Duration silence_limit = 5s;  ///< With device_lost: fault, no sentence for this long is one. Must be positive.
};

/// Declares the parameters with their defaults and ranges. Touches no hardware.
void declare_gps_parameters(Node& node);

/// Reads the declared parameters and checks them together.
/// Errors: a Problem that names the parameter, its value and the way out.
[[nodiscard]] Result<GpsOptions, Problem> read_gps_parameters(const Node& node);

}  // namespace nacelle::gps
