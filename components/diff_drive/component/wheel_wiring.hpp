// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

namespace nacelle::diff_drive {

/// How a wheel is wired to a motor board with channels.
struct WheelWiring {
  int channel = 0;           ///< In the board's own numbers.
  bool is_reversed = false;  ///< The motor turns backward when the board drives it forward.
};

/// Both wheels of a base, and what the board counts.
struct BaseWiring {
  WheelWiring left, right;
  double counts_per_turn = 1.0;  ///< Of the wheel, in the board's unit of position. Must be positive.

  [[nodiscard]] double rad_per_count() const { return 2.0 * std::numbers::pi / counts_per_turn; }
  /// Returns a wheel's rate as the board counts it, with the board's sign.
  [[nodiscard]] double counts_per_s(const WheelWiring& wheel, double rate_rps) const {
    return (wheel.is_reversed ? -rate_rps : rate_rps) / rad_per_count();
  }
  /// Returns what the board counts, in rad (or rad/s) of the wheel, positive forward.
  [[nodiscard]] double rad(const WheelWiring& wheel, double counts) const {
    return (wheel.is_reversed ? -counts : counts) * rad_per_count();
  }
};

}  // namespace nacelle::diff_drive
