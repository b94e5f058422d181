// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/leg.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::calibration {
namespace {

constexpr double kLeastMotion = 1e-3;  // of the target: more is motion
constexpr double kSlowest = 0.25;      // of the speed: motors stick below
constexpr double kSlack_s = 2.0;       // at full speed: no leg overshoots by more
constexpr int kStillReadings = 5;

}  // namespace

Leg::Leg(const LegSettings& settings, MonotonicTime now) : settings_(settings), moved_at_(now), heard_at_(now) {}

void Leg::take(double progress, MonotonicTime now) {
  heard_at_ = now;
  progress_ = progress;
  if (std::abs(progress - moved_to_) > kLeastMotion * settings_.target) {
    moved_to_ = progress;
    moved_at_ = now;
    stalls_ = still_readings_ = 0;
  } else {
    ++still_readings_;
  }
}

void Leg::pause(MonotonicTime now) {
  state_ = LegState::Pausing;
  pause_until_ = now + settings_.pause;
  speed_ = 0.0;
}

double Leg::command(MonotonicTime now) {
  if (is_over()) return 0.0;
  const Duration gap = commanded_at_ ? now - *commanded_at_ : Duration::zero();
  commanded_at_ = now;
  const double slack = kSlack_s * settings_.speed;
  if (now - heard_at_ > settings_.lost_after) {
    state_ = LegState::Lost;
  } else if (progress_ < -slack || progress_ > settings_.target + slack) {
    state_ = LegState::Astray;
  } else if (state_ != LegState::Stopping && progress_ >= settings_.target) {
    state_ = LegState::Stopping;
  } else if (state_ == LegState::Driving && (gap > settings_.late_after || now - heard_at_ > settings_.silent_after)) {
    pause(now);
  } else if (state_ == LegState::Stopping && now - moved_at_ > settings_.still_for &&
             still_readings_ >= kStillReadings) {
    state_ = LegState::Done;
  } else if (state_ == LegState::Pausing && now >= pause_until_ && now - heard_at_ <= settings_.silent_after) {
    state_ = LegState::Driving;
    moved_at_ = now;
  } else if (state_ == LegState::Driving && now - moved_at_ > settings_.stalled_after) {
    if (++stalls_ < settings_.most_stalls) {
      pause(now);
    } else {
      state_ = LegState::Stalled;
    }
  }
  if (state_ != LegState::Driving) return 0.0;
  // v^2 = 2 a s on the way down.
  const double end = std::sqrt(2.0 * settings_.acceleration * std::max(0.0, settings_.target - progress_));
  const double up = speed_ + settings_.acceleration * to_seconds(gap);
  speed_ = std::clamp(std::min(up, end), kSlowest * settings_.speed, settings_.speed);
  return speed_;
}

}  // namespace nacelle::calibration
