// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/described_base.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

#include "diff_drive/component/boards.hpp"

namespace nacelle::diff_drive {
namespace {

using description::ControlBlock;
using description::ControlDescription;
using description::ControlJoint;
using description::ControlParam;
using description::RobotJoint;

/// What a driver of ros2_control calls our parameter, and how many of ours one of its units is.
struct Alias {
  std::string_view name, parameter;
  double scale = 1.0;
};
// diffdrive_arduino and those that follow it; the Waveshare and Hiwonder bases' URDFs.
constexpr Alias kAliases[] = {
    {"device", "serial_port"},    {"port", "serial_port"},
    {"port_name", "serial_port"}, {"baud", "baud_rate"},
    {"baudrate", "baud_rate"},    {"timeout_ms", "port_timeout", 1e-3},
    {"timeout", "port_timeout"},  {"can", "can_interface"},
    {"loop_rate", "update_rate"}, {"enc_counts_per_rev", "counts_per_turn"},
};
/// Plugins that we stand for, by a part of their name.
struct Plugin {
  std::string_view part, hardware;
};
constexpr Plugin kPlugins[] = {{"mock_components/", "loopback"},
                               {"fake_components/", "loopback"},
                               {"loopback", "loopback"},
                               {"waveshare", "waveshare"},
                               {"roboclaw", "roboclaw"},
                               {"ugv", "waveshare"},
                               {"vesc_can", "vesc_can"},
                               {"vesc", "vesc"},
                               {"odrive_ros2_control", "odrive_can"},  // ODrive's own, over CAN
                               {"odrive_can", "odrive_can"},
                               {"odrive", "odrive"},
                               {"hiwonder", "hiwonder"},
                               {"nacelle/framed", "framed"},
                               {"nacelle/text", "text"},
                               {"nacelle/pwm", "pwm"}};

std::string lower(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

std::optional<double> number_in(const std::string& text) {
  double number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc{} || end != text.data() + text.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

class Reading {
 public:
  Reading(const ControlDescription& description, const GivenNames& given) : description_(description), given_(given) {
    base_.problems = description.errors;
    base_.warnings = description.warnings;
  }

  DescribedBase read() {
    take_wheels();
    take_lengths();
    for (const ControlBlock& block : description_.blocks) {
      if (!has_a_wheel(block)) continue;
      take_plugin(block);
      for (const ControlParam& param : block.params) take(param);
    }
    check_wheels("left_wheel_names", given_.left_wheels, base_.defaults.left_wheel_names);
    check_wheels("right_wheel_names", given_.right_wheels, base_.defaults.right_wheel_names);
    return std::move(base_);
  }

 private:
  void take_wheels() {
    if (given_.left_wheels && given_.right_wheels) return;
    auto wheels = description::wheels_of(description_);
    if (!wheels) {
      base_.problems.push_back(wheels.error());
      return;
    }
    if (wheels->left.empty() && wheels->right.empty()) return;  // blocks of an arm, or none at all
    base_.defaults.left_wheel_names = std::move(wheels->left);
    base_.defaults.right_wheel_names = std::move(wheels->right);
  }

  void take_lengths() {
    const auto lengths = description::wheel_lengths_of(
        description_, {given_.left_wheels ? *given_.left_wheels : base_.defaults.left_wheel_names,
                       given_.right_wheels ? *given_.right_wheels : base_.defaults.right_wheel_names});
    base_.defaults.wheel_separation_m = lengths.separation_m.value_or(base_.defaults.wheel_separation_m);
    base_.defaults.wheel_radius_m = lengths.radius_m.value_or(base_.defaults.wheel_radius_m);
  }

  [[nodiscard]] bool is_wheel(const std::string& joint) const {
    const auto& left = given_.left_wheels ? *given_.left_wheels : base_.defaults.left_wheel_names;
    const auto& right = given_.right_wheels ? *given_.right_wheels : base_.defaults.right_wheel_names;
    return std::ranges::find(left, joint) != left.end() || std::ranges::find(right, joint) != right.end();
  }
  [[nodiscard]] bool has_a_wheel(const ControlBlock& block) const {
    return std::ranges::any_of(block.joints, [&](const ControlJoint& joint) { return is_wheel(joint.name); });
  }

  void take_plugin(const ControlBlock& block) {
    const std::string name = lower(block.plugin);
    for (const Plugin& plugin : kPlugins) {
      if (name.find(plugin.part) == std::string::npos) continue;
      base_.defaults.hardware = plugin.hardware;
      return;
    }
    if (block.plugin.empty() || given_.hardware) return;
    std::string ours;
    for (const auto& hardware : hardware_names())
      ours += (ours.empty()                          ? "nacelle/"
               : hardware == hardware_names().back() ? " or nacelle/"
                                                     : ", nacelle/") +
              hardware;
    base_.warnings.push_back({block.plugin_where,
                              fmt::format("the hardware plugin '{}' is not run here; the base drives a {} board",
                                          block.plugin, base_.defaults.hardware),
                              fmt::format("say {}, or set the parameter hardware", ours)});
  }

  void take(const ControlParam& param) {
    std::string_view name = param.name;
    double scale = 1.0;
    for (const Alias& alias : kAliases) {
      if (alias.name != name) continue;
      name = alias.parameter;
      scale = alias.scale;
      break;
    }
    if (name == "left_wheel_name" || name == "right_wheel_name") return take_wheel(param);
    if (name == "serial_port") {
      base_.defaults.serial_port = param.value;
      return;
    }
    if (name == "can_interface") {
      base_.defaults.can_interface = param.value;
      return;
    }
    const auto number = number_in(param.value);
    if (double* const field = number_named(base_.defaults, name)) {
      if (!number) return refuse(param, "is not a number");
      *field = *number * scale;
    } else if (std::int64_t* const integer = integer_named(base_.defaults, name)) {
      if (!number || *number != std::trunc(*number) || std::abs(*number) > 1e15)
        return refuse(param, "is not a whole number");
      *integer = static_cast<std::int64_t>(*number);
    } else if (bool* const flag = switch_named(base_.defaults, name)) {
      const std::string value = lower(param.value);
      if (value != "true" && value != "false") return refuse(param, "is neither true nor false");
      *flag = value == "true";
    } else {
      warn_of(param);
    }
  }

  void refuse(const ControlParam& param, std::string_view what) {
    base_.problems.push_back(
        {param.where, fmt::format("'{}' {}, for the parameter '{}'", param.value, what, param.name), ""});
  }

  // The blocks' joints say the same; a name that is none of them is a mistake.
  void take_wheel(const ControlParam& param) {
    if (is_wheel(param.value)) return;
    std::vector<std::string> names;
    for (const ControlBlock& block : description_.blocks) {
      for (const ControlJoint& joint : block.joints) names.push_back(joint.name);
    }
    base_.problems.push_back(
        {param.where,
         fmt::format("{} names '{}', which no <joint> with a velocity command is", param.name, param.value),
         suggestion(param.value, names)});
  }

  void warn_of(const ControlParam& param) {
    std::vector<std::string> known = names_of_numbers();
    known.emplace_back("serial_port");
    known.emplace_back("can_interface");
    for (const Alias& alias : kAliases) known.emplace_back(alias.name);
    const std::string near = nearest_name(param.name, known);
    base_.warnings.push_back({param.where, fmt::format("the base has no use for the parameter '{}'", param.name),
                              near.empty() ? "encoders and their control are the motor board's own matter"
                                           : "did you mean '" + near + "'?"});
  }

  void check_wheels(const char* parameter, const std::optional<std::vector<std::string>>& given,
                    const std::vector<std::string>& described) {
    if (description_.joints.empty()) return;
    std::vector<std::string> names;
    for (const RobotJoint& joint : description_.joints) names.push_back(joint.name);
    for (const std::string& wheel : given ? *given : described) {
      const RobotJoint* const joint = description_.joint(wheel);
      if (joint == nullptr) {
        base_.problems.push_back({Place::of_parameter(parameter),
                                  fmt::format("{} holds '{}', and the robot has no such joint", parameter, wheel),
                                  suggestion(wheel, names)});
        continue;
      }
      if (joint->type != "continuous")
        base_.problems.push_back({joint->where,
                                  fmt::format("joint '{}' is a wheel ({}), and its type is {}", wheel, parameter,
                                              joint->type.empty() ? "missing" : "'" + joint->type + "'"),
                                  "a wheel turns without end: type=\"continuous\""});
      if (!description_.blocks.empty()) check_interfaces(wheel, parameter);
    }
  }

  void check_interfaces(const std::string& wheel, const char* parameter) {
    const ControlJoint* const joint = description_.controlled(wheel);
    if (joint == nullptr) {
      base_.problems.push_back({Place::of_parameter(parameter),
                                fmt::format("{} holds '{}', and no <ros2_control> block does", parameter, wheel),
                                "name it there, with a velocity command and position and velocity states"});
      return;
    }
    if (!joint->has_command("velocity"))
      base_.problems.push_back({joint->where, fmt::format("the wheel '{}' has no velocity command", wheel),
                                "add <command_interface name=\"velocity\"/>"});
    for (const auto& state : joint->states) {
      if (state.name == "position" || state.name == "velocity") continue;
      base_.warnings.push_back({state.where, fmt::format("the base does not measure the {} of '{}'", state.name, wheel),
                                "it measures position and velocity"});
    }
    for (const auto& command : joint->commands) {
      if (command.name == "velocity") continue;
      base_.warnings.push_back(
          {command.where, fmt::format("the base takes no {} for '{}'", command.name, wheel), "it takes a velocity"});
    }
  }

  const ControlDescription& description_;
  const GivenNames& given_;
  DescribedBase base_;
};

std::optional<std::vector<std::string>> given_names(const Node& node, const std::string& parameter) {
  const auto& overrides = node.parameters().overrides();
  const auto found = overrides.find(parameter);
  const auto* const names = found == overrides.end() ? nullptr : std::get_if<std::vector<std::string>>(&found->second);
  return names == nullptr ? std::nullopt : std::optional{*names};
}

}  // namespace

DescribedBase described_base(const ControlDescription& description, const GivenNames& given) {
  return Reading{description, given}.read();
}

DescribedBase read_described_base(Node& node) {
  const auto say = [](const char* text) { return ParameterDescriptor{.description = text, .read_only = true}; };
  description::RobotDescription robot;
  robot.urdf = node.declare_parameter("robot_description", "",
                                      say("The robot as URDF text: its <ros2_control> block is the base's defaults."));
  const auto file =
      node.declare_parameter("robot_description_file", "", say("A file that holds it, instead: URDF, or xacro."));
  const auto arguments = node.declare_parameter("xacro_arguments", std::vector<std::string>{},
                                                say("What the xacro file's arguments are, each \"name:=value\"."));
  DescribedBase none;
  if (!robot.urdf.empty() && !file.empty()) {
    none.problems.push_back(
        {Place::of_parameter("robot_description"), "robot_description_file is set, too", "give one of them"});
    return none;
  }
  if (!file.empty()) {
    auto read = description::read_description(file, arguments);
    if (!read) {
      none.problems.push_back(read.error());
      return none;
    }
    robot = std::move(read).value();
  }
  if (robot.urdf.empty()) return none;
  const GivenNames given{given_names(node, "left_wheel_names"), given_names(node, "right_wheel_names"),
                         node.parameters().overrides().count("hardware") != 0};
  return described_base(description::read_ros2_control(robot), given);
}

}  // namespace nacelle::diff_drive
