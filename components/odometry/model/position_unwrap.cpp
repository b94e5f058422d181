// SPDX-License-Identifier: Apache-2.0
#include "odometry/model/position_unwrap.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nacelle::odometry {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kFinest_rad = 1e-7;  // 26 bits a turn: nearer together are positions of no counter
constexpr int kLeastBits = 8;
// The largest change of speed in one sample, as a fraction of the highest speed. A match beyond that is chance.
constexpr double kUnexpected = 0.25;

/// The step that lies nearest to the expected one, on a circle.
double nearest(double change_rad, double circle_rad, double expected_rad) {
  return change_rad - circle_rad * std::round((change_rad - expected_rad) / circle_rad);
}

double common_divisor(double a, double b) {
  // Positions are products of whole numbers: rounding stays far below a thousandth of a step.
  while (b > kFinest_rad) {
    const double rest = std::abs(std::remainder(a, b));
    a = b;
    b = rest < 1e-3 * a ? 0.0 : rest;
  }
  return a;
}

}  // namespace

double PositionUnwrap::circle_of(double change_rad, double most_rad, double expected_rad, bool is_measured) const {
  const double off_rad = std::abs(change_rad - expected_rad);
  const double tolerance_rad = kUnexpected * most_rad;
  const bool cannot_be = std::abs(change_rad) > most_rad;
  if (highest_rad_ - lowest_rad_ <= kTurn_rad + kFinest_rad &&
      (cannot_be || (is_measured && off_rad > std::numbers::pi))) {
    const double step_rad = nearest(change_rad, kTurn_rad, expected_rad);
    if (std::abs(step_rad - expected_rad) <= std::min(tolerance_rad, 0.25 * kTurn_rad)) return kTurn_rad;
  }
  // When a counter wraps, the position jumps back while the wheel turns on.
  if (!cannot_be || tick_rad_ < kFinest_rad || change_rad * expected_rad > 0.0) return 0.0;
  const double bits = std::round(std::log2(off_rad / tick_rad_));
  const double circle_rad = std::exp2(bits) * tick_rad_;
  const double step_rad = nearest(change_rad, circle_rad, expected_rad);
  return bits >= kLeastBits && std::abs(step_rad - expected_rad) <= tolerance_rad ? circle_rad : 0.0;
}

void PositionUnwrap::learn(double change_rad) {
  const double size_rad = std::abs(change_rad);
  if (size_rad < kFinest_rad) return;
  tick_rad_ =
      tick_rad_ == 0.0 ? size_rad : common_divisor(std::max(size_rad, tick_rad_), std::min(size_rad, tick_rad_));
}

std::optional<double> PositionUnwrap::step(double position_rad, double most_rad, double expected_rad,
                                           bool is_measured) {
  if (!last_rad_) {
    last_rad_ = lowest_rad_ = highest_rad_ = position_rad;
    return std::nullopt;
  }
  const double change_rad = position_rad - *last_rad_;
  last_rad_ = position_rad;
  lowest_rad_ = std::min(lowest_rad_, position_rad);
  highest_rad_ = std::max(highest_rad_, position_rad);
  // Positions that span more than the circle count in none.
  if (!is_declared_ && highest_rad_ - lowest_rad_ > range_rad_ + kFinest_rad) range_rad_ = 0.0;
  const bool was_known = range_rad_ > 0.0;
  if (!was_known) range_rad_ = circle_of(change_rad, most_rad, expected_rad, is_measured);
  const double step_rad = range_rad_ > 0.0 ? nearest(change_rad, range_rad_, expected_rad) : change_rad;
  if (std::abs(step_rad) > most_rad) {
    lowest_rad_ = highest_rad_ = position_rad;
    return std::nullopt;
  }
  if (range_rad_ == 0.0) learn(change_rad);
  return step_rad;
}

}  // namespace nacelle::odometry
