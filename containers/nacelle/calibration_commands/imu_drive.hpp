// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "ask/nodes.hpp"
#include "calibration_commands/dialogue.hpp"
#include "calibration_commands/imu_calibration.hpp"
#include "imu/model/sample_correction.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::cli {

/// How an IMU sits on its base.
struct ImuMounting {
  imu::Vector3 mounting_rpy_rad{};    ///< The value of the parameter.
  imu::Vector3 place_m{}, rpy_rad{};  ///< Of the published frame in base_link: what the description should say.
  std::string frame, base_frame;
};

/// Drives figures of eight and finds the mounting yaw and the lever arm of an IMU from the base's wheels (model/lever_fit.hpp). `node`: the
/// IMU's; `mounting_rpy_rad`: its parameter now.
/// Errors: an exit code, printed.
[[nodiscard]] Result<ImuMounting, int> find_mounting(const ImuWish& wish, Dialogue& dialogue, ask::Nodes& nodes,
                                                     const std::string& node, const imu::Vector3& mounting_rpy_rad);

}  // namespace nacelle::cli
