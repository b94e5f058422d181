// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "diff_drive/model/axis_limits.hpp"
#include "diff_drive/model/drive_kinematics.hpp"

namespace nacelle::diff_drive {

/// Limits of both axes, already resolved().
struct TwistLimits {
  AxisLimits linear;
  AxisLimits angular;
};

/// Turns wanted twists into twists that the limits allow, and keeps the curvature of the path.
///
/// What happens to a wanted twist (v, w), when its predecessor was u0:
///  1. Velocity: both parts are scaled by one ratio, the smaller of the two axes' ratios, so that w/v stays.
///  2. Acceleration and jerk: if the base can move with that w/v in this cycle, it does, as fast as both axes allow
///     (one ratio again). From rest this is true at once, and stays true until the wanted twist is reached.
/// 3. Otherwise (braking to a stop, reversing, another curve at speed) no twist with that w/v is in reach: both parts
///     move the same share of their way from u0, the smaller share of the two axes. Braking to zero and reversing keep
///     the w/v of u0 so; a change of curve passes along the straight line between the two twists.
/// On one axis alone (the other is zero or constant) this is control_toolbox's limiter exactly.
///
/// Threads:   belongs to one thread. Allocates: nothing.
/// Source:    per axis control_toolbox RateLimiter; the joint rule is ours (see the laws in twist_limiter_test.cpp).
class TwistLimiter {
 public:
  explicit TwistLimiter(const TwistLimits& limits) : limits_(limits) {}

  /// The twist of this cycle. Preconditions: `wanted` is finite, dt_s > 0.
  BodyTwist limit(const BodyTwist& wanted, double dt_s);
  /// Resets the limiter: the base stands still now.
  void reset() { linear_ = angular_ = {}; }
  /// The last limited twist.
  [[nodiscard]] BodyTwist last() const { return {linear_.last, angular_.last}; }

 private:
  [[nodiscard]] BodyTwist reachable(const BodyTwist& wanted, double dt_s) const;

  TwistLimits limits_;
  AxisMemory linear_;
  AxisMemory angular_;
};

}  // namespace nacelle::diff_drive
