// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/diff_drive_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "nacelle/io/serial_port.hpp"

namespace nacelle::diff_drive {
namespace {

/// A numeric parameter, where its value lives and what is allowed: declaration, reading and check follow one table.
struct NumberRow {
  const char* name;
  double DiffDriveOptions::*field;
  double least;
  double most;
  const char* unit;
  const char* description;
};
constexpr NumberRow kNumbers[] = {
    {"wheel_separation", &DiffDriveOptions::wheel_separation_m, 0.01, 10.0, "m",
     "distance between the wheels' contact points"},
    {"wheel_radius", &DiffDriveOptions::wheel_radius_m, 0.001, 5.0, "m",
     "radius of a wheel, as configured in the board"},
    {"wheel_separation_multiplier", &DiffDriveOptions::wheel_separation_multiplier, 0.1, 10.0, "",
     "correction found by calibration"},
    {"left_wheel_radius_multiplier", &DiffDriveOptions::left_wheel_radius_multiplier, 0.1, 10.0, "",
     "correction found by calibration"},
    {"right_wheel_radius_multiplier", &DiffDriveOptions::right_wheel_radius_multiplier, 0.1, 10.0, "",
     "correction found by calibration"},
    {"cmd_vel_timeout", &DiffDriveOptions::cmd_vel_timeout_s, 0.0, 60.0, "s",
     "age at which a command is given up; 0 never"},
    {"update_rate", &DiffDriveOptions::update_rate_hz, 1.0, 1000.0, "Hz", "control cycles per second"},
    {"publish_rate", &DiffDriveOptions::publish_rate_hz, 0.0, 1000.0, "Hz",
     "joint states per second at most; 0 all of the board's"},
    {"battery_rate", &DiffDriveOptions::battery_rate_hz, 0.01, 100.0, "Hz", "battery states per second at most"},
    {"port_timeout", &DiffDriveOptions::port_timeout_s, 0.0, 60.0, "s",
     "how long to wait for the line, and how long it may be silent; 0 no wait, no limit"},
    {"motor_watchdog", &DiffDriveOptions::motor_watchdog_s, 0.0, 60.0, "s",
     "the board stops after this silence of ours; 0 its default"},
};

struct LimitRow {
  const char* name;
  double AxisLimits::*field;
};
constexpr LimitRow kLimits[] = {
    {"max_velocity", &AxisLimits::max_velocity},
    {"min_velocity", &AxisLimits::min_velocity},
    {"max_acceleration", &AxisLimits::max_acceleration},
    {"max_deceleration", &AxisLimits::max_deceleration},
    {"max_acceleration_reverse", &AxisLimits::max_acceleration_reverse},
    {"max_deceleration_reverse", &AxisLimits::max_deceleration_reverse},
    {"max_jerk", &AxisLimits::max_jerk},
    {"min_jerk", &AxisLimits::min_jerk},
};
struct SwitchRow {
  const char* name;
  bool AxisOptions::*field;
};
constexpr SwitchRow kSwitches[] = {
    {"has_velocity_limits", &AxisOptions::has_velocity_limits},
    {"has_acceleration_limits", &AxisOptions::has_acceleration_limits},
    {"has_jerk_limits", &AxisOptions::has_jerk_limits},
};
struct AxisRow {
  const char* prefix;
  AxisOptions DiffDriveOptions::*field;
};
constexpr AxisRow kAxes[] = {{"linear.x.", &DiffDriveOptions::linear}, {"angular.z.", &DiffDriveOptions::angular}};

const std::vector<std::string> kHardware{"waveshare", "loopback"};

ParameterDescriptor described(std::string text) {
  ParameterDescriptor descriptor;
  descriptor.description = std::move(text);
  return descriptor;
}

Duration period_of(double rate_hz) { return rate_hz > 0.0 ? from_seconds(1.0 / rate_hz) : Duration::zero(); }

/// Applies the deprecated names and fills in the defaults.
Result<AxisLimits, Problem> axis_limits(const AxisOptions& axis, const std::string& prefix, const std::string& node,
                                        std::vector<std::string>& warnings) {
  AxisLimits limits = axis.limits;
  const auto deprecated = [&](const char* name, const char* instead) {
    warnings.push_back(fmt::format("parameter {}{} is deprecated; {}", prefix, name, instead));
  };
  if (!std::isnan(axis.min_acceleration)) {
    deprecated("min_acceleration", "use max_deceleration and max_acceleration_reverse");
    if (!(axis.min_acceleration <= 0.0) || std::isinf(axis.min_acceleration)) {
      return err(Problem{fmt::format("node {}, parameter {}min_acceleration", node, prefix),
                         fmt::format("{} must be zero or negative, or .nan (off)", axis.min_acceleration),
                         "write a negative number"});
    }
    // It meant: between min and max acceleration, whichever way the base moves.
    if (std::isnan(limits.max_acceleration_reverse)) limits.max_acceleration_reverse = axis.min_acceleration;
    if (std::isnan(limits.max_deceleration)) limits.max_deceleration = axis.min_acceleration;
    if (std::isnan(limits.max_deceleration_reverse)) limits.max_deceleration_reverse = limits.max_acceleration;
  }
  if (!axis.has_velocity_limits) {
    deprecated("has_velocity_limits", "leave the limits at .nan instead");
    limits.max_velocity = limits.min_velocity = AxisLimits::kOff;
  }
  if (!axis.has_acceleration_limits) {
    deprecated("has_acceleration_limits", "leave the limits at .nan instead");
    limits.max_acceleration = limits.max_deceleration = limits.max_acceleration_reverse =
        limits.max_deceleration_reverse = AxisLimits::kOff;
  }
  if (!axis.has_jerk_limits) {
    deprecated("has_jerk_limits", "leave the limits at .nan instead");
    limits.max_jerk = limits.min_jerk = AxisLimits::kOff;
  }

  auto checked = resolved(limits);
  if (!checked) {
    const LimitFault& fault = checked.error();
    return err(Problem{
        fmt::format("node {}, parameter {}{}", node, prefix, fault.name), fmt::format("{} {}", fault.value, fault.rule),
        std::isfinite(fault.value) ? fmt::format("did you mean {}?", -fault.value) : "write .nan for no limit"});
  }
  return checked.value();
}

std::optional<Problem> problem_of_wheels(const DiffDriveOptions& options, const std::string& node) {
  const auto& left = options.left_wheel_names;
  const auto& right = options.right_wheel_names;
  if (left.empty() || right.empty()) {
    return Problem{fmt::format("node {}, parameter {}", node, left.empty() ? "left_wheel_names" : "right_wheel_names"),
                   "the list of joints is empty",
                   "name the wheels' joints of the robot description, e.g. [left_wheel_joint]"};
  }
  if (left.size() != right.size()) {
    return Problem{fmt::format("node {}, parameters left_wheel_names and right_wheel_names", node),
                   fmt::format("{} on the left, {} on the right", left.size(), right.size()),
                   "name as many wheels on each side"};
  }
  std::vector<std::string> all = left;
  all.insert(all.end(), right.begin(), right.end());
  std::sort(all.begin(), all.end());
  if (all.front().empty()) {
    return Problem{fmt::format("node {}, parameters left_wheel_names and right_wheel_names", node),
                   "a joint without a name", "name it"};
  }
  if (const auto twice = std::adjacent_find(all.begin(), all.end()); twice != all.end()) {
    return Problem{fmt::format("node {}, parameters left_wheel_names and right_wheel_names", node),
                   fmt::format("joint '{}' is named twice", *twice), "a wheel is on one side only"};
  }
  return std::nullopt;
}

std::optional<Problem> problem_of_hardware(const DiffDriveOptions& options, const std::string& node) {
  if (std::find(kHardware.begin(), kHardware.end(), options.hardware) == kHardware.end()) {
    return Problem{fmt::format("node {}, parameter hardware", node),
                   fmt::format("'{}' is no kind of base", options.hardware), suggestion(options.hardware, kHardware)};
  }
  if (options.hardware != "waveshare") return std::nullopt;
  if (options.serial_port.empty()) {
    return Problem{fmt::format("node {}, parameter serial_port", node), "no path",
                   "see `ls /dev/serial/by-id`, or start with sim:=true"};
  }
  if (options.baud_rate <= 0 || options.baud_rate > 10'000'000 ||
      !io::is_standard_baud(static_cast<unsigned>(options.baud_rate))) {
    return Problem{fmt::format("node {}, parameter baud_rate", node),
                   fmt::format("{} is not a standard baud rate", options.baud_rate), "the board speaks 115200"};
  }
  return std::nullopt;
}

}  // namespace

void declare_options(Node& node) {
  const DiffDriveOptions defaults;
  node.declare_parameter("left_wheel_names", defaults.left_wheel_names, described("joints of the wheels on the left"));
  node.declare_parameter("right_wheel_names", defaults.right_wheel_names,
                         described("joints of the wheels on the right"));
  for (const auto& row : kNumbers) {
    auto descriptor = described(row.description);
    descriptor.additional_constraints = fmt::format("{} to {} {}", row.least, row.most, row.unit);
    node.declare_parameter(row.name, defaults.*row.field, std::move(descriptor));
  }
  node.declare_parameter("publish_limited_velocity", defaults.publish_limited_velocity,
                         described("TwistStamped on ~/cmd_vel_out in every cycle"));
  for (const auto& axis : kAxes) {
    for (const auto& row : kLimits)
      node.declare_parameter(std::string(axis.prefix) + row.name, AxisLimits::kOff, described(".nan: no limit"));
    node.declare_parameter(std::string(axis.prefix) + "min_acceleration", AxisLimits::kOff, described("deprecated"));
    for (const auto& row : kSwitches)
      node.declare_parameter(std::string(axis.prefix) + row.name, true, described("deprecated"));
  }
  node.declare_parameter("hardware", defaults.hardware,
                         described("waveshare (UGV board on a serial line) or loopback (perfect wheels)"));
  node.declare_parameter("serial_port", defaults.serial_port,
                         described("path of the board's line; /dev/serial/by-id/... survives replugging"));
  node.declare_parameter("baud_rate", defaults.baud_rate, described("of the board's line"));
}

DiffDriveOptions read_options(const Node& node) {
  DiffDriveOptions options;
  options.left_wheel_names = node.get<std::vector<std::string>>("left_wheel_names");
  options.right_wheel_names = node.get<std::vector<std::string>>("right_wheel_names");
  for (const auto& row : kNumbers) options.*row.field = node.get<double>(row.name);
  options.publish_limited_velocity = node.get<bool>("publish_limited_velocity");
  for (const auto& row : kAxes) {
    AxisOptions& axis = options.*row.field;
    const std::string prefix = row.prefix;
    for (const auto& limit : kLimits) axis.limits.*limit.field = node.get<double>(prefix + limit.name);
    axis.min_acceleration = node.get<double>(prefix + "min_acceleration");
    for (const auto& flag : kSwitches) axis.*flag.field = node.get<bool>(prefix + flag.name);
  }
  options.hardware = node.get<std::string>("hardware");
  options.serial_port = node.get<std::string>("serial_port");
  options.baud_rate = node.get<std::int64_t>("baud_rate");
  return options;
}

Result<DriveSetup, Problem> validated(const DiffDriveOptions& options, const std::string& node) {
  if (auto problem = problem_of_wheels(options, node)) return err(std::move(*problem));
  for (const auto& row : kNumbers) {
    const double value = options.*row.field;
    if (value >= row.least && value <= row.most) continue;  // NaN is in no range
    return err(Problem{fmt::format("node {}, parameter {}", node, row.name),
                       fmt::format("{} is not in {} to {} {}", value, row.least, row.most, row.unit),
                       fmt::format("the default is {}", DiffDriveOptions{}.*row.field)});
  }
  if (auto problem = problem_of_hardware(options, node)) return err(std::move(*problem));

  DriveSetup setup;
  auto linear = axis_limits(options.linear, "linear.x.", node, setup.warnings);
  if (!linear) return err(linear.error());
  auto angular = axis_limits(options.angular, "angular.z.", node, setup.warnings);
  if (!angular) return err(angular.error());

  setup.loop.geometry = {options.wheel_separation_m * options.wheel_separation_multiplier,
                         options.wheel_radius_m * options.left_wheel_radius_multiplier,
                         options.wheel_radius_m * options.right_wheel_radius_multiplier};
  setup.loop.limits = {linear.value(), angular.value()};
  setup.loop.period = period_of(options.update_rate_hz);
  setup.loop.command_timeout = from_seconds(options.cmd_vel_timeout_s);
  setup.loop.silence_limit = from_seconds(options.port_timeout_s);
  setup.publish_period = period_of(options.publish_rate_hz);
  setup.battery_period = period_of(options.battery_rate_hz);
  return setup;
}

}  // namespace nacelle::diff_drive
