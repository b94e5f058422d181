// SPDX-License-Identifier: Apache-2.0
#include "joy/component/joy_options.hpp"

#include <fmt/format.h>

namespace nacelle::joy {
namespace {

ParameterDescriptor text(std::string description) { return {.description = std::move(description)}; }
ParameterDescriptor within(std::string description, double from, double to) {
  return {.description = std::move(description), .floating_point_range = FloatingPointRange{from, to}};
}
ParameterDescriptor count_within(std::string description, std::int64_t from, std::int64_t to) {
  return {.description = std::move(description), .integer_range = IntegerRange{from, to}};
}

}  // namespace

std::string JoyOptions::title() const {
  if (!wish.path.empty()) return wish.path;
  return wish.name.empty() ? fmt::format("gamepad {}", wish.index) : fmt::format("gamepad '{}'", wish.name);
}

void declare_joy_parameters(Node& node) {
  const JoyOptions defaults;
  node.declare_parameter("device_id", 0,
                         count_within("number of the gamepad among those that are there, from 0", 0, 31));
  node.declare_parameter("device_name", "",
                         text("name of the gamepad, as the kernel knows it; then device_id does not count"));
  node.declare_parameter(
      "dev", "", text("path of the gamepad, e.g. /dev/input/by-id/usb-...-event-joystick; then neither counts"));
  node.declare_parameter("deadzone", defaults.pad.deadzone,
                         within("share of an axis' way around its middle that counts as 0", 0.0, 0.99));
  node.declare_parameter("autorepeat_rate", 20.0,
                         within("Hz, of an unchanged state; 0: only changes are published", 0.0, 1000.0));
  node.declare_parameter("coalesce_interval_ms", 1,
                         count_within("ms within which moves of axes are one message", 0, 1000));
  node.declare_parameter("sticky_buttons", defaults.pad.sticky_buttons, text("true: a press switches a button over"));
  node.declare_parameter("silence_limit", to_seconds(defaults.silence_limit),
                         within("s without the gamepad that are a fault, with device_lost: fault", 0.01, 3600.0));
  declare_device_parameters(node);
}

Result<JoyOptions, Problem> read_joy_parameters(const Node& node) {
  JoyOptions options;
  options.wish.path = node.get<std::string>("dev");
  options.wish.name = node.get<std::string>("device_name");
  options.wish.index = static_cast<std::size_t>(node.get<std::int64_t>("device_id"));
  options.pad.deadzone = node.get<double>("deadzone");
  options.pad.sticky_buttons = node.get<bool>("sticky_buttons");
  const double rate_hz = node.get<double>("autorepeat_rate");
  options.pace.repeat = rate_hz > 0.0 ? from_seconds(1.0 / rate_hz) : Duration::zero();
  options.pace.coalesce = std::chrono::milliseconds{node.get<std::int64_t>("coalesce_interval_ms")};
  options.silence_limit = from_seconds(node.get<double>("silence_limit"));
  auto device = read_device_parameters(node);
  if (!device) return err(device.error());
  options.device = *device;
  return options;
}

}  // namespace nacelle::joy
