// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::diff_drive {

/// The parameters of a base that this computer drives itself (`hardware: pwm`): its pins, and how they are controlled.
struct PwmOptions {
  std::string chip = "/sys/class/pwm/pwmchip0";
  std::string gpio_chip = "/dev/gpiochip0";
  std::vector<std::int64_t> left_lines, right_lines;  ///< IN1 and IN2 of a motor's H-bridge.
  double frequency_hz = 1000.0;
  bool is_inverted = false;
  double min_duty = 0.0, max_duty = 1.0;
  std::string encoder = "gpio";                                       ///< Or "counter".
  std::vector<std::int64_t> left_encoder_lines, right_encoder_lines;  ///< A and B of a wheel's encoder; or A alone.
  std::string left_counter, right_counter;
  bool left_encoder_reversed = false, right_encoder_reversed = false;
  double p = 0.02, i = 0.2, d = 0.0;
  double feed_forward = 0.0;
  double derivative_filter_s = 0.02;
  double stall_timeout_s = 1.0;
};

/// Declares the parameters `pwm.*`, with these defaults.
void declare_pwm_options(Node& node, const PwmOptions& defaults);
[[nodiscard]] PwmOptions read_pwm_options(const Node& node);
/// Checks them; `node` is the node that has them.
[[nodiscard]] std::optional<Problem> problem_of_pwm(const PwmOptions& options, const std::string& node);

}  // namespace nacelle::diff_drive
