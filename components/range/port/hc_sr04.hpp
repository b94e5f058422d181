// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "range/port/echo_lines.hpp"

namespace nacelle::range {

/// Why there is no measurement.
enum class EchoFault : std::uint8_t {
  NoPulse,  ///< The sensor did not answer the trigger: it has no power, or its wires are on other lines.
  Woken,    ///< interrupt() was called.
  Lost      ///< The kernel refuses to read or set the lines: the chip was removed.
};

/// An HC-SR04: triggers it and times its echo pulse with the kernel's times of the edges, so that a delayed thread changes nothing.
///
/// The trigger is high for 10 us at least; the sensor answers with a pulse as long as the sound was on its way. Without an obstacle the pulse
/// ends after 38 ms; with some copies later, or when something comes near: they are not triggered before.
/// Source:    ElecFreaks, HC-SR04 User Guide ("Timing diagram").
/// Threads:   one.
/// Allocates: nothing.
class HcSr04 {
 public:
  HcSr04(EchoLines& lines, const Clock& clock) : lines_(lines), clock_(clock) {}

  /// Returns how long the sound was on its way; kNoObstacle if none came back. Takes 50 ms at the most.
  [[nodiscard]] Result<Duration, EchoFault> measure();

  static constexpr Duration kTriggerPulse = 10us;
  /// The pulse begins about half a millisecond after the trigger, when the burst of 8 cycles has left.
  static constexpr Duration kLongestAnswer = 10ms;
  static constexpr Duration kNoObstacle = 38ms;

 private:
  EchoLines& lines_;
  const Clock& clock_;
  bool is_high_ = false;  // the echo line, by its last edge
};

}  // namespace nacelle::range
