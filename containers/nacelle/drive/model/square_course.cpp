// SPDX-License-Identifier: Apache-2.0
#include "drive/model/square_course.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nacelle::drive {
namespace {

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * std::numbers::pi); }

/// The highest rate from which one still stops within `left`, if braking begins `reaction_s` from now.
/// Source: left = v * reaction + v^2 / (2 a), solved for v.
double stoppable(double left, double acceleration, double reaction_s) {
  const double lead = acceleration * reaction_s;
  return left > 0 ? std::sqrt(lead * lead + 2 * acceleration * left) - lead : 0;
}

double towards(double value, double goal, double step) { return value + std::clamp(goal - value, -step, step); }

constexpr double kHeadingGain = 2.5;     // 1/s
constexpr double kCrossTrackGain = 4.0;  // rad/(m s): critically damped against the heading gain near full speed
constexpr double kSteeringLimit_rps = 0.6;
// Below this the wheels' counts are too coarse to go on creeping: it counts as arrived.
constexpr double kCreep_mps = 0.012, kCreep_rps = 0.04;
constexpr double kStandingStill_mps = 1e-3, kStandingStill_rps = 1e-3;
constexpr double kYawWorthMending_rad = 0.02;
constexpr unsigned kMostCorrections = 2;
constexpr double kProgress_m = 0.005, kProgress_rad = 0.01;

}  // namespace

SquareCourse::SquareCourse(const CourseOptions& options) : options_(options) {}

VelocityCommand SquareCourse::step(const PlanarPose& pose, MonotonicTime now) {
  if (!started_) {
    started_ = true;
    last_ = corner_ = progress_pose_ = pose;
    goal_yaw_rad_ = pose.yaw_rad;
    last_step_ = rests_since_ = progress_at_ = now;
    return command_;
  }
  // A late call must not turn into a jump of the command.
  const double dt_s = std::clamp(to_seconds(now - last_step_), 0.0, 0.1);
  last_step_ = now;
  distance_m_ += std::hypot(pose.x_m - last_.x_m, pose.y_m - last_.y_m);
  last_ = pose;

  switch (phase_) {
    case CoursePhase::Straight:
      command_ = drive_side(pose, dt_s);
      note_progress(pose, now);
      break;
    case CoursePhase::Turn:
      command_ = turn(pose, dt_s);
      note_progress(pose, now);
      break;
    case CoursePhase::Settle:
      command_ = brake(dt_s);
      settle(now);
      progress_at_ = now;
      progress_pose_ = pose;
      break;
    case CoursePhase::Rest: rest(now); break;
    case CoursePhase::Done:
    case CoursePhase::Stalled: command_ = brake(dt_s); break;
  }
  if (phase_ == CoursePhase::Settle) {
    // drive_side() and turn() enter it on arrival; the clock of the rest begins at standstill.
    if (std::abs(command_.speed_mps) > kStandingStill_mps || std::abs(command_.yaw_rate_rps) > kStandingStill_rps)
      rests_since_ = now;
  }
  return command_;
}

VelocityCommand SquareCourse::drive_side(const PlanarPose& pose, double dt_s) {
  const double along_x = std::cos(corner_.yaw_rad), along_y = std::sin(corner_.yaw_rad);
  const double dx_m = pose.x_m - corner_.x_m, dy_m = pose.y_m - corner_.y_m;
  const double left_m = options_.side_m - (dx_m * along_x + dy_m * along_y);
  const double cross_m = -dx_m * along_y + dy_m * along_x;  // positive: to the left of the side
  const double heading_rad = wrapped(pose.yaw_rad - corner_.yaw_rad);

  const double goal_mps =
      std::min(options_.speed_mps, stoppable(left_m, options_.acceleration_mps2, to_seconds(options_.reaction)));
  VelocityCommand command;
  command.speed_mps = towards(command_.speed_mps, goal_mps, options_.acceleration_mps2 * dt_s);
  // Steering fades with the speed, or the robot would turn on the spot to mend a millimetre.
  const double speed_share = std::clamp(command.speed_mps / options_.speed_mps, 0.0, 1.0);
  const double steer_rps = -kHeadingGain * heading_rad - kCrossTrackGain * cross_m;
  const double goal_rps = std::clamp(steer_rps * speed_share, -kSteeringLimit_rps, kSteeringLimit_rps);
  command.yaw_rate_rps = towards(command_.yaw_rate_rps, goal_rps, options_.yaw_acceleration_rps2 * dt_s);

  const bool arrived = left_m <= options_.position_tolerance_m || (goal_mps < kCreep_mps && left_m < 0.05);
  if (arrived) {
    ++sides_done_;
    // The next corner is where it should be, not where we are.
    corner_.x_m += options_.side_m * along_x;
    corner_.y_m += options_.side_m * along_y;
    corner_.yaw_rad = wrapped(corner_.yaw_rad + 2 * std::numbers::pi / options_.sides);
    next_is_turn_ = true;
    phase_ = CoursePhase::Settle;
    rests_since_ = last_step_;
  }
  return command;
}

VelocityCommand SquareCourse::turn(const PlanarPose& pose, double dt_s) {
  const double left_rad = wrapped(goal_yaw_rad_ - pose.yaw_rad);
  const double goal_rps = std::min(options_.yaw_rate_rps, stoppable(std::abs(left_rad), options_.yaw_acceleration_rps2,
                                                                    to_seconds(options_.reaction)));
  VelocityCommand command;
  command.speed_mps = towards(command_.speed_mps, 0, options_.acceleration_mps2 * dt_s);
  command.yaw_rate_rps =
      towards(command_.yaw_rate_rps, std::copysign(goal_rps, left_rad), options_.yaw_acceleration_rps2 * dt_s);
  if (std::abs(left_rad) <= options_.yaw_tolerance_rad || (goal_rps < kCreep_rps && std::abs(left_rad) < 0.05)) {
    next_is_turn_ = false;
    phase_ = CoursePhase::Settle;
    rests_since_ = last_step_;
  }
  return command;
}

VelocityCommand SquareCourse::brake(double dt_s) {
  return {towards(command_.speed_mps, 0, options_.acceleration_mps2 * dt_s),
          towards(command_.yaw_rate_rps, 0, options_.yaw_acceleration_rps2 * dt_s)};
}

void SquareCourse::settle(MonotonicTime now) {
  const bool last_rest = sides_done_ == options_.sides && !next_is_turn_;
  if (now - rests_since_ < (last_rest ? options_.final_settle : options_.settle)) return;
  // A robot slower to answer than `reaction` has turned too far: seen at rest, it is mended at rest.
  const bool has_turned = sides_done_ > 0 && !next_is_turn_;
  if (has_turned && corrections_ < kMostCorrections &&
      std::abs(wrapped(goal_yaw_rad_ - last_.yaw_rad)) > kYawWorthMending_rad) {
    ++corrections_;
    phase_ = CoursePhase::Turn;
    return;
  }
  corrections_ = 0;
  if (last_rest) {
    phase_ = CoursePhase::Done;
  } else if (next_is_turn_) {
    goal_yaw_rad_ = corner_.yaw_rad;
    phase_ = CoursePhase::Turn;
  } else {
    phase_ = CoursePhase::Straight;
  }
}

void SquareCourse::note_progress(const PlanarPose& pose, MonotonicTime now) {
  const double moved_m = std::hypot(pose.x_m - progress_pose_.x_m, pose.y_m - progress_pose_.y_m);
  if (moved_m > kProgress_m || std::abs(wrapped(pose.yaw_rad - progress_pose_.yaw_rad)) > kProgress_rad) {
    progress_pose_ = pose;
    progress_at_ = now;
    rested_ = false;
  } else if (phase_ == CoursePhase::Settle) {
    return;  // it has just arrived
  } else if (now - progress_at_ > options_.stall_limit) {
    phase_ = CoursePhase::Stalled;
  } else if (now - progress_at_ > options_.rest_after && !rested_) {
    rested_ = true;
    resumes_ = phase_;
    phase_ = CoursePhase::Rest;
    rests_since_ = now;
    rest(now);
  }
}

// The robot stands already, so the command is zero at once.
void SquareCourse::rest(MonotonicTime now) {
  command_ = {};
  if (now - rests_since_ >= options_.rest) phase_ = resumes_;
}

}  // namespace nacelle::drive
