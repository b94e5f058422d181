// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "lidar/component/lidar_models.hpp"
#include "lidar/model/scan_assembler.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/node/device_watch.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::lidar {

/// The parameters of the component, under the names of the makers' ROS drivers where they have one.
struct LidarOptions {
  LidarModel model = lidar_models().front();
  std::string port_name = "/dev/ttyUSB0";
  unsigned port_baudrate = 230400;
  std::string frame_id = "lidar_link";
  std::string topic_name = "scan";
  std::string scan_mode{};  ///< RPLIDAR: as the device names it; empty: the one it recommends.
  ScanOptions scan{};
  DeviceOptions device{};
  Duration port_timeout = 2s;   ///< With required_device: how long configure waits for the port to appear.
  Duration silence_limit = 2s;  ///< With device_lost: fault, no frame for this long is one. Must be positive.
};

/// Declares the parameters with their ranges and the model's defaults. Touches no hardware.
void declare_lidar_parameters(Node& node);

/// Reads the declared parameters and checks them together.
/// Errors: a Problem that names the parameter, its value and the way out.
[[nodiscard]] Result<LidarOptions, Problem> read_lidar_parameters(const Node& node);

/// Makes what speaks to the model.
[[nodiscard]] std::unique_ptr<LidarProtocol> make_protocol(const LidarOptions& options);

}  // namespace nacelle::lidar
