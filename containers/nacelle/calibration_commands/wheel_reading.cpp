// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/wheel_reading.hpp"

#include <algorithm>

#include "calibration_commands/imu_message.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

std::vector<std::string> names_in(const ParametersOf& parameters, const std::string& name) {
  std::vector<std::string> names;
  const auto found = parameters.find(name);
  if (found == parameters.end() || !found->second.is_array()) return names;
  for (const auto& one : found->second) {
    if (one.is_string()) names.push_back(one.get<std::string>());
  }
  return names;
}

/// The timeout of a topic of commands: of the `topics.NAME.topic` that names it, else the one that all share.
double timeout_s(const ParametersOf& parameters, const std::string& node, const std::string& topic) {
  constexpr std::string_view kPrefix = "topics.", kSuffix = ".topic";
  for (const auto& [name, value] : parameters) {
    if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix) || !value.is_string()) continue;
    if (beside(node, value.get<std::string>()) == topic)
      return number_in(parameters, name.substr(0, name.size() - kSuffix.size()) + ".timeout", 0.5);
  }
  return number_in(parameters, "cmd_vel_timeout", 0.5);
}

/// The mean position of some joints; nothing if one of them is missing.
std::optional<double> mean_position(const json& names, const json& positions, const std::vector<std::string>& joints) {
  double sum = 0.0;
  for (const auto& joint : joints) {
    const auto found = std::find(names.begin(), names.end(), joint);
    const auto index = static_cast<std::size_t>(found - names.begin());
    if (found == names.end() || index >= positions.size() || !positions[index].is_number()) return std::nullopt;
    sum += positions[index].get<double>();
  }
  return sum / static_cast<double>(joints.size());
}

}  // namespace

Result<BaseParameters, Problem> base_parameters(const ParametersOf& parameters, const std::string& node,
                                                const std::string& topic) {
  BaseParameters base;
  base.left_joints = names_in(parameters, "left_wheel_names");
  base.right_joints = names_in(parameters, "right_wheel_names");
  auto& g = base.geometry;
  g.wheel_radius_m = number_in(parameters, "wheel_radius", 0.0);
  g.wheel_separation_m = number_in(parameters, "wheel_separation", 0.0);
  g.left_radius_multiplier = number_in(parameters, "left_wheel_radius_multiplier", 0.0);
  g.right_radius_multiplier = number_in(parameters, "right_wheel_radius_multiplier", 0.0);
  g.separation_multiplier = number_in(parameters, "wheel_separation_multiplier", 0.0);
  base.command_timeout = from_seconds(timeout_s(parameters, node, topic));
  const bool is_base = !base.left_joints.empty() && !base.right_joints.empty() && g.left_radius_m() > 0.0 &&
                       g.right_radius_m() > 0.0 && g.separation_m() > 0.0;
  // The odometry has the wheels' parameters, too, but no board.
  if (!is_base || !parameters.contains("hardware"))
    return err(Problem{node, "is not a nacelle::diff_drive::DiffDriveComponent", "name the base's node with --node"});
  return base;
}

std::optional<calibration::WheelTurn> wheels_in(const json& joint_state, const BaseParameters& base) {
  const auto names = joint_state.find("name"), positions = joint_state.find("position");
  if (names == joint_state.end() || positions == joint_state.end() || !names->is_array() || !positions->is_array())
    return std::nullopt;
  const auto left = mean_position(*names, *positions, base.left_joints);
  const auto right = mean_position(*names, *positions, base.right_joints);
  if (!left || !right) return std::nullopt;
  return calibration::WheelTurn{*left, *right};
}

std::optional<WheelSample> sample_in(const json& joint_state, const BaseParameters& base) {
  const auto turn = wheels_in(joint_state, base);
  if (!turn) return std::nullopt;
  try {
    return WheelSample{stamp_s(joint_state), *turn};
  } catch (const json::exception&) {
    return std::nullopt;  // of another type
  }
}

}  // namespace nacelle::cli
