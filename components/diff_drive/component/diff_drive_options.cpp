// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/diff_drive_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "diff_drive/component/boards.hpp"
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
     "age after which a command is ignored; 0: never"},
    {"emergency_stop_timeout", &DiffDriveOptions::emergency_stop_timeout_s, 0.1, 60.0, "s",
     "with emergency_stop_required: the longest that the emergency stop's publisher may show no sign of life"},
    {"update_rate", &DiffDriveOptions::update_rate_hz, 1.0, 1000.0, "Hz", "control cycles per second"},
    {"publish_rate", &DiffDriveOptions::publish_rate_hz, 0.0, 1000.0, "Hz",
     "joint states per second at most; 0 all of the board's"},
    {"battery_rate", &DiffDriveOptions::battery_rate_hz, 0.01, 100.0, "Hz", "battery states per second at most"},
    {"port_timeout", &DiffDriveOptions::port_timeout_s, 0.0, 60.0, "s",
     "how long to wait for the line (required_device), and how long it may be silent (device_lost: fault); 0 no wait, "
     "no "
     "limit"},
    {"reopen_timeout", &DiffDriveOptions::reopen_timeout_s, 0.0, 86400.0, "s",
     "with device_lost: fault, how long a line that was lost is waited for; 0 a lost line is a fault at once"},
    {"motor_watchdog", &DiffDriveOptions::motor_watchdog_s, 0.0, 60.0, "s",
     "the board stops after this silence of ours; 0 its default"},
    {"counts_per_turn", &DiffDriveOptions::counts_per_turn, 0.0, 1e8, "",
     "what the board counts while a wheel turns once (roboclaw, pwm: edges of the encoder; vesc, vesc_can: 6 * pole "
     "pairs * gear; odrive, odrive_can: gear; hiwonder: gear behind its motors); 0 its usual one"},
    {"max_wheel_rate", &DiffDriveOptions::max_wheel_rate_rps, 0.1, 10000.0, "rad/s",
     "no wheel is commanded to turn faster, and a wheel that seems to is a restart of the board"},
};

struct LimitRow {
  const char* name;
  double AxisLimits::*field;
  const char* per;  // behind the axis' unit
};
constexpr LimitRow kLimits[] = {
    {"max_velocity", &AxisLimits::max_velocity, "/s"},
    {"min_velocity", &AxisLimits::min_velocity, "/s"},
    {"max_acceleration", &AxisLimits::max_acceleration, "/s^2"},
    {"max_deceleration", &AxisLimits::max_deceleration, "/s^2"},
    {"max_acceleration_reverse", &AxisLimits::max_acceleration_reverse, "/s^2"},
    {"max_deceleration_reverse", &AxisLimits::max_deceleration_reverse, "/s^2"},
    {"max_jerk", &AxisLimits::max_jerk, "/s^3"},
    {"min_jerk", &AxisLimits::min_jerk, "/s^3"},
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
  const char* unit;
};
constexpr AxisRow kAxes[] = {{"linear.x.", &DiffDriveOptions::linear, "m"},
                             {"angular.z.", &DiffDriveOptions::angular, "rad"}};

struct IntegerRow {
  std::string_view name;
  std::int64_t DiffDriveOptions::*field;
  const char* description;
};
constexpr const char* kChannel = "the wheel's channel in the board's own numbers; -1: the usual one";
constexpr IntegerRow kIntegers[] = {
    {"baud_rate", &DiffDriveOptions::baud_rate, "speed of the board's line, baud; 0: the board's usual one"},
    {"board_address", &DiffDriveOptions::board_address,
     "address of the board on its line (roboclaw: 128 to 135); 0: its usual one"},
    {"left_channel", &DiffDriveOptions::left_channel, kChannel},
    {"right_channel", &DiffDriveOptions::right_channel, kChannel},
};
struct BoardSwitchRow {
  std::string_view name;
  bool DiffDriveOptions::*field;
};
constexpr BoardSwitchRow kBoardSwitches[] = {{"left_reversed", &DiffDriveOptions::left_reversed},
                                             {"right_reversed", &DiffDriveOptions::right_reversed}};

const std::vector<std::string> kRearm{"neutral", "fresh"};
constexpr const char* kTopics = "topics.";
constexpr const char* kLocks = "locks.";
constexpr Duration kFeedbackPeriod = 50ms;  // of a Waveshare UGV board, about 20 Hz; of boards that are asked, a cycle

/// The NAMEs of "topics.NAME.priority" and its like, in their order.
std::vector<std::string> names_below(const Node& node, std::string_view prefix) {
  std::vector<std::string> names;
  for (const auto& [key, value] : node.parameters().overrides()) {
    if (key.rfind(prefix, 0) != 0) continue;
    const std::size_t end = key.find('.', prefix.size());
    if (end == std::string::npos || end == prefix.size()) continue;
    std::string name = key.substr(prefix.size(), end - prefix.size());
    if (names.empty() || names.back() != name) names.push_back(std::move(name));
  }
  return names;
}

template <typename Channel>
Channel read_channel(const Node& node, const std::string& prefix, const std::string& name) {
  const std::string at = prefix + name;
  return {name, node.get<std::string>(at + ".topic"), node.get<double>(at + ".timeout"),
          node.get<std::int64_t>(at + ".priority")};
}

/// "a, b or c"
std::string one_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return text;
}

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
      return err(Problem{Place::of_parameter(prefix + "min_acceleration", node),
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
        Place::of_parameter(fmt::format("{}{}", prefix, fault.name), node),
        fmt::format("{} {}", fault.value, fault.rule),
        std::isfinite(fault.value) ? fmt::format("did you mean {}?", -fault.value) : "write .nan for no limit"});
  }
  return checked.value();
}

std::optional<Problem> problem_of_wheels(const DiffDriveOptions& options, const std::string& node) {
  const auto& left = options.left_wheel_names;
  const auto& right = options.right_wheel_names;
  if (left.empty() || right.empty()) {
    return Problem{Place::of_parameter(left.empty() ? "left_wheel_names" : "right_wheel_names", node),
                   "the list of joints is empty",
                   "name the wheels' joints of the robot description, e.g. [left_wheel_joint]"};
  }
  if (left.size() != right.size()) {
    return Problem{Place::of_parameter("right_wheel_names", node),
                   fmt::format("{} on the left, {} on the right", left.size(), right.size()),
                   "name as many wheels on each side"};
  }
  std::vector<std::string> all = left;
  all.insert(all.end(), right.begin(), right.end());
  std::sort(all.begin(), all.end());
  if (all.front().empty()) {
    return Problem{Place::of_parameter("right_wheel_names", node), "a joint without a name", "name it"};
  }
  if (const auto twice = std::adjacent_find(all.begin(), all.end()); twice != all.end()) {
    return Problem{Place::of_parameter("right_wheel_names", node), fmt::format("joint '{}' is named twice", *twice),
                   "a wheel is on one side only"};
  }
  return std::nullopt;
}

std::optional<Problem> problem_of_hardware(const DiffDriveOptions& options, const std::string& node) {
  const auto& names = hardware_names();
  if (std::find(names.begin(), names.end(), options.hardware) == names.end()) {
    return Problem{Place::of_parameter("hardware", node), fmt::format("'{}' is not a kind of base", options.hardware),
                   suggestion(options.hardware, names)};
  }
  const BoardKind* const kind = board_kind(options.hardware);
  if (kind == nullptr) return std::nullopt;
  if (kind->is_pwm) return problem_of_board(options, node);
  if (kind->is_on_can) {
    if (options.can_interface.empty())
      return Problem{Place::of_parameter("can_interface", node), "no interface", "see `ip -details link`"};
    return problem_of_board(options, node);
  }
  if (options.serial_port.empty()) {
    return Problem{Place::of_parameter("serial_port", node), "no path", "see `ls -l /dev/serial/by-id`"};
  }
  if (options.baud_rate != 0 && (options.baud_rate < 0 || options.baud_rate > 10'000'000 ||
                                 !io::is_standard_baud(static_cast<unsigned>(options.baud_rate)))) {
    return Problem{Place::of_parameter("baud_rate", node),
                   fmt::format("{} is not a standard baud rate", options.baud_rate),
                   fmt::format("a {} board usually speaks {}", kind->name, kind->usual_baud)};
  }
  return problem_of_board(options, node);
}

std::optional<Problem> problem_of_channel(const std::string& prefix, const std::string& name, const std::string& topic,
                                          double timeout_s, std::int64_t priority, const std::string& node) {
  const auto where = [&](const char* key) {
    return Place::of_parameter(fmt::format("{}{}.{}", prefix, name, key), node);
  };
  if (topic.empty()) return Problem{where("topic"), "no topic is named", "e.g. cmd_vel_joy"};
  if (!(timeout_s >= 0.0 && timeout_s <= 60.0)) {
    return Problem{where("timeout"), fmt::format("{} is not in 0 to 60 s", timeout_s),
                   "0.5 is usual; 0 never times out"};
  }
  if (priority < 0 || priority > 255)
    return Problem{where("priority"), fmt::format("{} is not in 0 to 255", priority), "the highest of them commands"};
  return std::nullopt;
}

std::optional<Problem> problem_of_input(const DiffDriveOptions& options, const std::string& node) {
  for (const auto& input : options.inputs) {
    if (input.name.empty()) continue;
    if (auto problem = problem_of_channel(kTopics, input.name, input.topic, input.timeout_s, input.priority, node))
      return problem;
  }
  for (const auto& lock : options.locks) {
    if (auto problem = problem_of_channel(kLocks, lock.name, lock.topic, lock.timeout_s, lock.priority, node))
      return problem;
  }
  if (std::find(kRearm.begin(), kRearm.end(), options.rearm) == kRearm.end()) {
    return Problem{Place::of_parameter("rearm", node), fmt::format("'{}' is not a rule", options.rearm),
                   suggestion(options.rearm, kRearm)};
  }
  return std::nullopt;
}

CommandInput::Settings input_settings(const DiffDriveOptions& options) {
  CommandInput::Settings settings;
  settings.sources.clear();
  for (const auto& input : options.inputs)
    settings.sources.push_back({from_seconds(input.timeout_s), static_cast<std::uint8_t>(input.priority)});
  for (const auto& lock : options.locks)
    settings.locks.push_back({from_seconds(lock.timeout_s), static_cast<std::uint8_t>(lock.priority)});
  settings.rearm = options.rearm == "fresh" ? RearmRule::Fresh : RearmRule::Neutral;
  return settings;
}

}  // namespace

double* number_named(DiffDriveOptions& options, std::string_view parameter) {
  const auto row = std::find_if(std::begin(kNumbers), std::end(kNumbers),
                                [&](const NumberRow& candidate) { return candidate.name == parameter; });
  return row == std::end(kNumbers) ? nullptr : &(options.*row->field);
}

std::int64_t* integer_named(DiffDriveOptions& options, std::string_view parameter) {
  for (const IntegerRow& row : kIntegers) {
    if (row.name == parameter) return &(options.*row.field);
  }
  return nullptr;
}

bool* switch_named(DiffDriveOptions& options, std::string_view parameter) {
  for (const BoardSwitchRow& row : kBoardSwitches) {
    if (row.name == parameter) return &(options.*row.field);
  }
  return nullptr;
}

std::vector<std::string> names_of_numbers() {
  std::vector<std::string> names;
  for (const auto& row : kNumbers) names.emplace_back(row.name);
  for (const auto& row : kIntegers) names.emplace_back(row.name);
  for (const auto& row : kBoardSwitches) names.emplace_back(row.name);
  return names;
}

void declare_options(Node& node, const DiffDriveOptions& defaults) {
  node.declare_parameter("left_wheel_names", defaults.left_wheel_names, described("joints of the wheels on the left"));
  node.declare_parameter("right_wheel_names", defaults.right_wheel_names,
                         described("joints of the wheels on the right"));
  for (const auto& row : kNumbers) {
    auto descriptor = described(row.description);
    descriptor.additional_constraints =
        fmt::format("{} to {}{}{}", row.least, row.most, *row.unit == '\0' ? "" : " ", row.unit);
    node.declare_parameter(row.name, defaults.*row.field, std::move(descriptor));
  }
  node.declare_parameter("emergency_stop_required", defaults.emergency_stop_required,
                         described("the wheels stay stopped while no live publisher of the emergency stop is there"));
  node.declare_parameter("publish_limited_velocity", defaults.publish_limited_velocity,
                         described("TwistStamped on ~/cmd_vel_out in every cycle"));
  node.declare_parameter(
      "use_stamped_vel", defaults.use_stamped_vel,
      described("on the network an input without a publisher is TwistStamped, else Twist; a publisher "
                "of the other type changes it, and both are taken"));
  for (const auto& axis : kAxes) {
    for (const auto& row : kLimits)
      node.declare_parameter(std::string(axis.prefix) + row.name, AxisLimits::kOff,
                             described(fmt::format("{}{}; .nan: no limit", axis.unit, row.per)));
    node.declare_parameter(
        std::string(axis.prefix) + "min_acceleration", AxisLimits::kOff,
        described(fmt::format("{}/s^2; deprecated: use max_deceleration and max_acceleration_reverse", axis.unit)));
    for (const auto& row : kSwitches)
      node.declare_parameter(std::string(axis.prefix) + row.name, true,
                             described("deprecated: set the limits to .nan instead of false"));
  }
  for (const auto& name : names_below(node, kTopics)) {
    const std::string at = kTopics + name;
    node.declare_parameter(at + ".topic", std::string{}, described("a topic of commands, Twist or TwistStamped"));
    node.declare_parameter(at + ".timeout", InputOptions{}.timeout_s,
                           described("s; age after which its command is ignored; 0: never"));
    node.declare_parameter(at + ".priority", InputOptions{}.priority, described("0 to 255; the highest commands"));
  }
  for (const auto& name : names_below(node, kLocks)) {
    const std::string at = kLocks + name;
    node.declare_parameter(at + ".topic", std::string{},
                           described("std_msgs/Bool; true locks inputs of a lower priority"));
    node.declare_parameter(at + ".timeout", LockOptions{}.timeout_s,
                           described("s; a lock that is silent for longer is locked; 0: never"));
    node.declare_parameter(at + ".priority", LockOptions{}.priority, described("0 to 255"));
  }
  node.declare_parameter(
      "rearm", defaults.rearm,
      described("what lets the base move again after a stop: neutral (its input was zero or silent for one "
                "timeout, then a new command) or fresh (a new command)"));
  node.declare_parameter("controller_manager", false,
                         {.description = "true: the node controller_manager answers `ros2 control`",
                          .additional_constraints = "",
                          .read_only = true});
  node.declare_parameter("hardware", defaults.hardware,
                         described("the motor board: " + one_of(hardware_names()) + " (perfect wheels)"));
  node.declare_parameter("serial_port", defaults.serial_port,
                         described("path of the board's line; /dev/serial/by-id/... survives replugging"));
  node.declare_parameter("can_interface", defaults.can_interface,
                         described("the network interface of boards on a CAN bus (odrive_can, vesc_can)"));
  for (const IntegerRow& row : kIntegers)
    node.declare_parameter(std::string(row.name), defaults.*row.field, described(row.description));
  for (const BoardSwitchRow& row : kBoardSwitches)
    node.declare_parameter(std::string(row.name), defaults.*row.field,
                           described("the motor and its encoder turn backward when the board drives forward"));
  declare_pwm_options(node, defaults.pwm);
  declare_device_parameters(node);
}

DiffDriveOptions read_options(const Node& node) {
  DiffDriveOptions options;
  options.left_wheel_names = node.get<std::vector<std::string>>("left_wheel_names");
  options.right_wheel_names = node.get<std::vector<std::string>>("right_wheel_names");
  for (const auto& row : kNumbers) options.*row.field = node.get<double>(row.name);
  options.emergency_stop_required = node.get<bool>("emergency_stop_required");
  options.publish_limited_velocity = node.get<bool>("publish_limited_velocity");
  options.use_stamped_vel = node.get<bool>("use_stamped_vel");
  for (const auto& row : kAxes) {
    AxisOptions& axis = options.*row.field;
    const std::string prefix = row.prefix;
    for (const auto& limit : kLimits) axis.limits.*limit.field = node.get<double>(prefix + limit.name);
    axis.min_acceleration = node.get<double>(prefix + "min_acceleration");
    for (const auto& flag : kSwitches) axis.*flag.field = node.get<bool>(prefix + flag.name);
  }
  options.inputs[0].timeout_s = options.cmd_vel_timeout_s;
  if (const auto names = names_below(node, kTopics); !names.empty()) {
    options.inputs.clear();
    for (const auto& name : names) options.inputs.push_back(read_channel<InputOptions>(node, kTopics, name));
  }
  for (const auto& name : names_below(node, kLocks))
    options.locks.push_back(read_channel<LockOptions>(node, kLocks, name));
  options.rearm = node.get<std::string>("rearm");
  options.hardware = node.get<std::string>("hardware");
  options.serial_port = node.get<std::string>("serial_port");
  options.can_interface = node.get<std::string>("can_interface");
  for (const IntegerRow& row : kIntegers) options.*row.field = node.get<std::int64_t>(std::string(row.name));
  for (const BoardSwitchRow& row : kBoardSwitches) options.*row.field = node.get<bool>(std::string(row.name));
  options.pwm = read_pwm_options(node);
  return options;
}

Result<DriveSetup, Problem> validated(const DiffDriveOptions& options, const std::string& node) {
  if (auto problem = problem_of_wheels(options, node)) return err(std::move(*problem));
  for (const auto& row : kNumbers) {
    const double value = options.*row.field;
    if (value >= row.least && value <= row.most) continue;  // NaN is in no range
    return err(Problem{Place::of_parameter(row.name, node),
                       fmt::format("{} is not in {} to {} {}", value, row.least, row.most, row.unit),
                       fmt::format("the default is {}", DiffDriveOptions{}.*row.field)});
  }
  if (auto problem = problem_of_hardware(options, node)) return err(std::move(*problem));
  if (auto problem = problem_of_input(options, node)) return err(std::move(*problem));

  DriveSetup setup;
  warn_of_board(options, setup.warnings);
  auto linear = axis_limits(options.linear, "linear.x.", node, setup.warnings);
  if (!linear) return err(linear.error());
  auto angular = axis_limits(options.angular, "angular.z.", node, setup.warnings);
  if (!angular) return err(angular.error());

  setup.loop.geometry = {options.wheel_separation_m * options.wheel_separation_multiplier,
                         options.wheel_radius_m * options.left_wheel_radius_multiplier,
                         options.wheel_radius_m * options.right_wheel_radius_multiplier};
  setup.loop.limits = {linear.value(), angular.value()};
  setup.loop.period = period_of(options.update_rate_hz);
  setup.loop.input = input_settings(options);
  setup.loop.reopen_limit = from_seconds(options.reopen_timeout_s);
  setup.loop.motor_watchdog = from_seconds(options.motor_watchdog_s);
  setup.loop.silence_limit = from_seconds(options.port_timeout_s);
  setup.loop.waits_for_board = options.device.lost == DeviceLost::Wait;
  setup.loop.silence_report = silence_of(std::max(kFeedbackPeriod, setup.loop.period));
  setup.publish_period = period_of(options.publish_rate_hz);
  setup.battery_period = period_of(options.battery_rate_hz);
  return setup;
}

}  // namespace nacelle::diff_drive
