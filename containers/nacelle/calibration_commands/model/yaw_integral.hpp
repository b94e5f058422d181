// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>

namespace nacelle::calibration {

/// Adds up a yaw rate to a turn, by the trapezoidal rule. Turns are counted: the sum is not wrapped.
///
/// Threads: one. Allocates: nothing.
class YawIntegral {
 public:
  /// `bias_rps`: what the gyro reads at rest; taken off.
  explicit YawIntegral(double bias_rps) : bias_rps_(bias_rps) {}

  /// Takes a reading and its stamp in s. A stamp that is not later than the last one counts as a gap.
  void take(double stamp_s, double rate_rps) {
    const double rate = rate_rps - bias_rps_;
    if (last_s_) {
      const double dt = stamp_s - *last_s_;
      longest_gap_s_ = std::max(longest_gap_s_, dt > 0.0 ? dt : kMostGap_s + 1.0);
      if (dt > 0.0) yaw_rad_ += 0.5 * (rate + last_rate_) * dt;
    }
    last_s_ = stamp_s;
    last_rate_ = rate;
    ++readings_;
  }

  [[nodiscard]] double yaw_rad() const { return yaw_rad_; }
  [[nodiscard]] double longest_gap_s() const { return longest_gap_s_; }
  /// Whether the readings were dense enough for the sum to be a measurement.
  [[nodiscard]] bool is_whole() const { return readings_ > 1 && longest_gap_s_ <= kMostGap_s; }

  /// Of a rate that changes by a in 1 s^2 the rule misses less than a / 8 times this squared, at each bend.
  static constexpr double kMostGap_s = 0.5;

 private:
  double bias_rps_;
  double yaw_rad_ = 0.0, last_rate_ = 0.0, longest_gap_s_ = 0.0;
  std::optional<double> last_s_;
  std::size_t readings_ = 0;
};

}  // namespace nacelle::calibration
