// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace nacelle::odometry {

/// How far one wheel turned between two positions of an encoder that may count in a circle.
///
/// A declared range is believed. Without one a change that the wheel cannot have made is taken for the end of a circle
/// if that leaves a step as expected: a circle of one turn (+-pi, 0 to 2 pi) while every position lay within one turn,
/// or one of 2^n steps of a counter (n from 8) where every change was a multiple of one step. Anything else is a jump:
/// the counter restarted.
/// Threads: one. Allocates: nothing.
class PositionUnwrap {
 public:
  /// 0: the range is not declared.
  explicit PositionUnwrap(double declared_range_rad = 0.0)
      : range_rad_(declared_range_rad), is_declared_(declared_range_rad > 0.0) {}

  /// The next position starts the differences anew. Knowledge of the circle is kept.
  void restart() { last_rad_.reset(); }
  /// The step since the last position, or nothing for the first one and after a jump. `most_rad` is the longest step that the wheel
  /// can have made, `expected_rad` the likely one; `is_measured`: the latter is from a measured speed.
  [[nodiscard]] std::optional<double> step(double position_rad, double most_rad, double expected_rad, bool is_measured);
  /// 0: none is known.
  [[nodiscard]] double range_rad() const { return range_rad_; }

 private:
  [[nodiscard]] double circle_of(double change_rad, double most_rad, double expected_rad, bool is_measured) const;
  void learn(double change_rad);

  double range_rad_;
  bool is_declared_;
  std::optional<double> last_rad_;
  double lowest_rad_ = 0.0, highest_rad_ = 0.0;  // since the last jump
  double tick_rad_ = 0.0;                        // the greatest common divisor of all changes; below kFinest: none
};

}  // namespace nacelle::odometry
