// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <span>

#include "diff_drive/port/pwm_channel.hpp"
#include "nacelle/io/gpio_lines.hpp"

namespace nacelle::diff_drive {

/// Two motors behind H-bridges of the L298N's kind: a PWM input and two direction lines each.
///
///   forward: IN1 high, IN2 low; backward: IN1 low, IN2 high; both low: the motor coasts
///
/// A direction changes only while the motor's output is off, so no motor gets the other one's share for a moment.
/// Threads: one. Allocates: nothing but in reopen().
/// Source:  ST, L298 data sheet, "bidirectional DC motor control"; Toshiba, TB6612FNG data sheet, "H-SW control function".
class HBridges {
 public:
  /// The lines are IN1 and IN2 of the left motor, then of the right one.
  HBridges(std::unique_ptr<PwmChannel> left, std::unique_ptr<PwmChannel> right, std::unique_ptr<io::GpioOutputs> lines);
  ~HBridges();
  HBridges(const HBridges&) = delete;
  HBridges& operator=(const HBridges&) = delete;

  /// Sets how strong each motor drives: its share of the supply, negative backward. Returns false if the kernel refuses; then both may be as
  /// before. Precondition: -1 <= share <= 1.
  [[nodiscard]] bool set(double left, double right);
  /// Switches all off, as far as the kernel does it. Returns false if it refuses any.
  bool stop();
  /// Opens everything anew, switched off. Returns false if anything is still gone.
  [[nodiscard]] bool reopen();
  /// PwmChannel::kStop on each of these stops both motors.
  [[nodiscard]] std::span<const int> descriptors() const { return descriptors_; }

 private:
  const std::array<std::unique_ptr<PwmChannel>, 2> channels_;
  const std::unique_ptr<io::GpioOutputs> lines_;
  const std::array<int, 2> descriptors_;
  std::uint64_t levels_ = 0;
};

}  // namespace nacelle::diff_drive
