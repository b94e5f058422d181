// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/pwm_options.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nacelle::diff_drive {
namespace {

struct PwmNumber {
  const char* name;
  double PwmOptions::*field;
  double least;
  double most;
  const char* unit;
  const char* description;
};
constexpr PwmNumber kPwmNumbers[] = {
    {"pwm.frequency", &PwmOptions::frequency_hz, 10.0, 100000.0, "Hz", "of the PWM outputs"},
    {"pwm.min_duty", &PwmOptions::min_duty, 0.0, 0.9, "",
     "share of the supply below which the motors do not turn (dead band)"},
    {"pwm.max_duty", &PwmOptions::max_duty, 0.05, 1.0, "", "share of the supply that a motor gets at most"},
    {"pwm.p", &PwmOptions::p, 0.0, 100.0, "1/(rad/s)", "share of the supply per rad/s of error of a wheel's speed"},
    {"pwm.i", &PwmOptions::i, 0.0, 100.0, "1/rad", "share of the supply per rad of error that has added up"},
    {"pwm.d", &PwmOptions::d, 0.0, 100.0, "1/(rad/s^2)", "share of the supply per rad/s^2 of the measured speed"},
    {"pwm.feed_forward", &PwmOptions::feed_forward, 0.0, 100.0, "1/(rad/s)",
     "share of the supply per rad/s that is wanted: 1 / (a wheel's speed at full supply)"},
    {"pwm.derivative_filter", &PwmOptions::derivative_filter_s, 0.0, 1.0, "s",
     "time constant of the low pass of pwm.d; 0 none"},
    {"pwm.stall_timeout", &PwmOptions::stall_timeout_s, 0.0, 60.0, "s",
     "a wheel that stands, or turns the wrong way, at full output for so long is a fault that stops the base; 0 never"},
};

struct PwmText {
  const char* name;
  std::string PwmOptions::*field;
  const char* description;
};
constexpr PwmText kPwmTexts[] = {
    {"pwm.chip", &PwmOptions::chip, "hardware: pwm: the kernel's PWM chip; left_channel and right_channel are of it"},
    {"pwm.gpio_chip", &PwmOptions::gpio_chip, "the GPIO chip of the direction lines and of the encoders"},
    {"pwm.encoder", &PwmOptions::encoder, "what counts the encoders: gpio (edges of lines) or counter (the kernel)"},
    {"pwm.left_counter", &PwmOptions::left_counter,
     "pwm.encoder: counter: the wheel's count, /sys/bus/counter/devices/counter0/count0"},
    {"pwm.right_counter", &PwmOptions::right_counter, "as pwm.left_counter"},
};

struct PwmSwitch {
  const char* name;
  bool PwmOptions::*field;
  const char* description;
};
constexpr PwmSwitch kPwmSwitches[] = {
    {"pwm.inverted", &PwmOptions::is_inverted, "the H-bridge drives while its PWM input is low"},
    {"pwm.left_encoder_reversed", &PwmOptions::left_encoder_reversed,
     "the encoder counts the other way than its motor turns"},
    {"pwm.right_encoder_reversed", &PwmOptions::right_encoder_reversed, "as pwm.left_encoder_reversed"},
};

struct PwmLines {
  const char* name;
  std::vector<std::int64_t> PwmOptions::*field;
  const char* description;
};
constexpr PwmLines kPwmLines[] = {
    {"pwm.left_lines", &PwmOptions::left_lines, "GPIO lines IN1 and IN2 of the left motor's H-bridge"},
    {"pwm.right_lines", &PwmOptions::right_lines, "GPIO lines IN1 and IN2 of the right motor's H-bridge"},
    {"pwm.left_encoder_lines", &PwmOptions::left_encoder_lines,
     "pwm.encoder: gpio: GPIO lines A and B of the wheel's encoder, or its only one"},
    {"pwm.right_encoder_lines", &PwmOptions::right_encoder_lines, "as pwm.left_encoder_lines"},
};

constexpr std::size_t kEdgeChannels = 2;

ParameterDescriptor pwm_described(const char* text) {
  ParameterDescriptor descriptor;
  descriptor.description = text;
  return descriptor;
}

/// Each line has one use.
std::optional<Problem> problem_of_lines(const PwmOptions& options, const std::string& node) {
  const bool has_edges = options.encoder == "gpio";
  std::vector<std::int64_t> used;
  for (const PwmLines& row : kPwmLines) {
    const auto& lines = options.*row.field;
    const bool is_encoder =
        row.field == &PwmOptions::left_encoder_lines || row.field == &PwmOptions::right_encoder_lines;
    if (is_encoder && !has_edges) continue;
    const auto problem = [&](std::string what, std::string way_out) {
      return Problem{Place::of_parameter(row.name, node), std::move(what), std::move(way_out)};
    };
    if (is_encoder ? lines.empty() || lines.size() > kEdgeChannels : lines.size() != 2) {
      return problem(fmt::format("{} GPIO lines are named", lines.size()),
                     is_encoder ? "name A and B of the encoder, e.g. [5, 6], or its only one"
                                : "name IN1 and IN2 of the H-bridge, e.g. [23, 24]");
    }
    for (const std::int64_t line : lines) {
      if (line < 0 || line > 1023)
        return problem(fmt::format("{} is no GPIO line", line),
                       "`gpioinfo` lists them; on a Raspberry Pi the BCM numbers");
      if (std::find(used.begin(), used.end(), line) != used.end())
        return problem(fmt::format("line {} has another use already", line), "each wire has a line of its own");
      used.push_back(line);
    }
  }
  if (has_edges && options.left_encoder_lines.size() != options.right_encoder_lines.size()) {
    return Problem{Place::of_parameter("pwm.right_encoder_lines", node),
                   "one encoder has two channels and the other one",
                   "name as many lines for each; counts_per_turn is that of both"};
  }
  return std::nullopt;
}

}  // namespace

void declare_pwm_options(Node& node, const PwmOptions& defaults) {
  for (const PwmText& row : kPwmTexts)
    node.declare_parameter(row.name, defaults.*row.field, pwm_described(row.description));
  for (const PwmLines& row : kPwmLines)
    node.declare_parameter(row.name, defaults.*row.field, pwm_described(row.description));
  for (const PwmSwitch& row : kPwmSwitches)
    node.declare_parameter(row.name, defaults.*row.field, pwm_described(row.description));
  for (const PwmNumber& row : kPwmNumbers) {
    auto descriptor = pwm_described(row.description);
    descriptor.additional_constraints =
        fmt::format("{} to {}{}{}", row.least, row.most, *row.unit == '\0' ? "" : " ", row.unit);
    node.declare_parameter(row.name, defaults.*row.field, std::move(descriptor));
  }
}

PwmOptions read_pwm_options(const Node& node) {
  PwmOptions options;
  for (const PwmText& row : kPwmTexts) options.*row.field = node.get<std::string>(row.name);
  for (const PwmLines& row : kPwmLines) options.*row.field = node.get<std::vector<std::int64_t>>(row.name);
  for (const PwmSwitch& row : kPwmSwitches) options.*row.field = node.get<bool>(row.name);
  for (const PwmNumber& row : kPwmNumbers) options.*row.field = node.get<double>(row.name);
  return options;
}

std::optional<Problem> problem_of_pwm(const PwmOptions& options, const std::string& node) {
  const auto at = [&](const char* parameter) { return Place::of_parameter(parameter, node); };
  for (const PwmNumber& row : kPwmNumbers) {
    const double value = options.*row.field;
    if (value >= row.least && value <= row.most) continue;  // NaN is in no range
    return Problem{at(row.name), fmt::format("{} is not in {} to {} {}", value, row.least, row.most, row.unit),
                   fmt::format("the default is {}", PwmOptions{}.*row.field)};
  }
  if (options.min_duty >= options.max_duty)
    return Problem{at("pwm.min_duty"), fmt::format("{} is not below pwm.max_duty", options.min_duty),
                   "no speed would be left"};
  if (options.chip.empty()) return Problem{at("pwm.chip"), "no chip is named", "`ls -d /sys/class/pwm/*` lists them"};
  if (options.encoder != "gpio" && options.encoder != "counter")
    return Problem{at("pwm.encoder"), fmt::format("'{}' counts no encoders", options.encoder), "gpio or counter"};
  if (options.encoder == "counter" && (options.left_counter.empty() || options.right_counter.empty())) {
    return Problem{at(options.left_counter.empty() ? "pwm.left_counter" : "pwm.right_counter"), "no count is named",
                   "`ls -d /sys/bus/counter/devices/*/count*` lists them"};
  }
  if (options.p == 0.0 && options.i == 0.0 && options.feed_forward == 0.0)
    return Problem{at("pwm.i"), "pwm.p, pwm.i and pwm.feed_forward are all 0: no wheel would turn",
                   "the default is 0.2"};
  return problem_of_lines(options, node);
}

}  // namespace nacelle::diff_drive
