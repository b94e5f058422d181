// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/wheel_pid.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::diff_drive {
namespace {

/// A wheel that has turned less than this has been pushed, or its encoder has a bad contact.
constexpr double kNoTurnRad = 0.05;

}  // namespace

double WheelPid::update(double wanted_rps, double measured_rps, double dt_s) {
  dt_s = std::min(dt_s, kLongestStep);
  const bool is_step = has_last_ && dt_s > 0.0;
  if (is_step) {
    const double slope_rps2 = (measured_rps - last_rps_) / dt_s;
    slope_rps2_ += dt_s / (settings_.filter_s + dt_s) * (slope_rps2 - slope_rps2_);
  }
  if (is_step || !has_last_) last_rps_ = measured_rps;
  has_last_ = true;

  const double limit = settings_.output_limit;
  const double error_rps = wanted_rps - measured_rps;
  const double without = settings_.feed_forward * wanted_rps + settings_.p * error_rps - settings_.d * slope_rps2_;
  if (is_step) {
    const double step = settings_.i * error_rps * dt_s;
    // What is left until the output is at its limit; none if it is there.
    const double room = std::max(0.0, step > 0.0 ? limit - without - integral_ : limit + without + integral_);
    integral_ = std::clamp(integral_ + std::clamp(step, -room, room), -limit, limit);
  }
  return std::clamp(without + integral_, -limit, limit);
}

void WheelPid::reset() {
  integral_ = slope_rps2_ = last_rps_ = 0.0;
  has_last_ = false;
}

double beyond_dead_band(double output, double least, double most) {
  if (output == 0.0) return 0.0;
  return std::copysign(std::min(least + std::abs(output) * (1.0 - least), most), output);
}

WheelWatch::Finding WheelWatch::update(bool is_limited, double moved_rad, double dt_s) {
  if (!is_limited || limit_s_ <= 0.0) {
    reset();
    return Finding::None;
  }
  since_s_ += std::max(dt_s, 0.0);
  moved_rad_ += moved_rad;
  if (moved_rad_ > kNoTurnRad) {
    reset();
    return Finding::None;
  }
  if (since_s_ < limit_s_) return Finding::None;
  return moved_rad_ < -kNoTurnRad ? Finding::Reversed : Finding::Stands;
}

}  // namespace nacelle::diff_drive
