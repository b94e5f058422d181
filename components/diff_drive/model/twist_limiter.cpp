// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/twist_limiter.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace nacelle::diff_drive {
namespace {

double ratio_of(double limited, double wanted) { return wanted == 0.0 ? 1.0 : limited / wanted; }

BodyTwist within_velocity(const TwistLimits& limits, const BodyTwist& wanted) {
  const double ratio = std::min(ratio_of(within_velocity(limits.linear, wanted.linear_mps), wanted.linear_mps),
                                ratio_of(within_velocity(limits.angular, wanted.angular_rps), wanted.angular_rps));
  if (ratio >= 1.0) return wanted;
  // The clamp takes away what rounding left of the product above the limit.
  const BodyTwist slower = scaled(wanted, ratio);
  return {within_velocity(limits.linear, slower.linear_mps), within_velocity(limits.angular, slower.angular_rps)};
}

/// Factors s for which s * wanted is in reach of an axis.
struct FactorRange {
  double lowest = 0.0;
  double highest = 1.0;
};

FactorRange narrowed(FactorRange factors, const SpeedChangeRange& change, double last, double wanted) {
  if (wanted == 0.0) {
    const bool can_be_zero = change.lowest <= -last && -last <= change.highest;
    return can_be_zero ? factors : FactorRange{1.0, 0.0};
  }
  double lowest = (last + change.lowest) / wanted;
  double highest = (last + change.highest) / wanted;
  if (wanted < 0.0) std::swap(lowest, highest);
  return {std::max(factors.lowest, lowest), std::min(factors.highest, highest)};
}

/// Which share of its way an axis gets; empty when it has no way to go.
std::optional<double> share_of(double limited, double last, double wanted) {
  // Below this a difference is rounding, and a share of it would hold up the other axis.
  constexpr double kNoWay = 1e-12;
  if (std::abs(wanted - last) <= kNoWay) return std::nullopt;
  return (limited - last) / (wanted - last);
}

}  // namespace

BodyTwist TwistLimiter::limit(const BodyTwist& wanted, double dt_s) {
  const BodyTwist next = reachable(within_velocity(limits_, wanted), dt_s);
  linear_ = {next.linear_mps, linear_.last};
  angular_ = {next.angular_rps, angular_.last};
  return next;
}

BodyTwist TwistLimiter::reachable(const BodyTwist& wanted, double dt_s) const {
  const double linear_mps = limited_speed(limits_.linear, linear_, wanted.linear_mps, dt_s);
  const double angular_rps = limited_speed(limits_.angular, angular_, wanted.angular_rps, dt_s);
  if (linear_mps == wanted.linear_mps && angular_rps == wanted.angular_rps) return wanted;

  const auto linear_share = share_of(linear_mps, linear_.last, wanted.linear_mps);
  const auto angular_share = share_of(angular_rps, angular_.last, wanted.angular_rps);

  // A jerk limit can force an axis to continue in its old direction for a while. Its share is negative then.
  const bool forced_on = linear_share.value_or(0.0) < 0.0 || angular_share.value_or(0.0) < 0.0;
  if (!forced_on) {
    FactorRange factors;
    factors = narrowed(factors, allowed_change(limits_.linear, linear_, dt_s), linear_.last, wanted.linear_mps);
    factors = narrowed(factors, allowed_change(limits_.angular, angular_, dt_s), angular_.last, wanted.angular_rps);
    if (factors.highest >= factors.lowest && factors.highest > 0.0) return scaled(wanted, factors.highest);
  }

  if (!linear_share || !angular_share) return {linear_mps, angular_rps};
  // No change is always allowed, so with opposite senses both axes hold for this one cycle.
  if (*linear_share * *angular_share <= 0.0) return last();
  if (std::abs(*linear_share) <= std::abs(*angular_share)) {
    return {linear_mps, angular_.last + *linear_share * (wanted.angular_rps - angular_.last)};
  }
  return {linear_.last + *angular_share * (wanted.linear_mps - linear_.last), angular_rps};
}

}  // namespace nacelle::diff_drive
