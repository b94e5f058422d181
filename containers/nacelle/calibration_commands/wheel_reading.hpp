// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration_commands/model/base_fit.hpp"
#include "calibration_commands/parameter_lines.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::cli {

/// What the parameters of a nacelle::diff_drive::DiffDriveComponent say.
struct BaseParameters {
  std::vector<std::string> left_joints, right_joints;
  calibration::BaseGeometry geometry;
  Duration command_timeout{};  ///< Of the topic that is commanded on; 0: commands stay in force.
};
/// `topic`: the topic of commands, its full name. Errors: the node is no such base.
[[nodiscard]] Result<BaseParameters, Problem> base_parameters(const ParametersOf& parameters, const std::string& node,
                                                              const std::string& topic);

/// A reading of the wheels.
struct WheelSample {
  double stamp_s = 0.0;  ///< Since the epoch of the stamps' clock.
  calibration::WheelTurn turn;
};

/// Returns the wheels' positions in a sensor_msgs/JointState as JSON; nothing if it lacks one of them.
[[nodiscard]] std::optional<calibration::WheelTurn> wheels_in(const nlohmann::json& joint_state,
                                                              const BaseParameters& base);
/// As wheels_in(), with the message's stamp; nothing without one, too.
[[nodiscard]] std::optional<WheelSample> sample_in(const nlohmann::json& joint_state, const BaseParameters& base);

}  // namespace nacelle::cli
