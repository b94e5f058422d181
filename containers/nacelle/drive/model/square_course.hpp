// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nacelle/base/time.hpp"

namespace nacelle::drive {

/// Pose of the base in odom, X_OB, on the floor.
struct PlanarPose {
  double x_m = 0, y_m = 0, yaw_rad = 0;
};

/// A command for the base; forward and counter-clockwise are positive.
struct VelocityCommand {
  double speed_mps = 0, yaw_rate_rps = 0;
};

struct CourseOptions {
  double side_m = 1.0;
  unsigned sides = 4;              ///< Equal sides of a regular polygon; 4 is the square.
  double speed_mps = 0.3;          ///< Top speed along a side.
  double yaw_rate_rps = 1.0;       ///< Top rate while turning in place.
  double acceleration_mps2 = 0.4;  ///< Low enough that the wheels keep their grip.
  double yaw_acceleration_rps2 = 1.5;
  /// The delay from a command to the pose that shows its effect: wheels, odometry, filter, socket. Braking begins this
  /// much earlier.
  Duration reaction = 120ms;
  double position_tolerance_m = 0.006;
  double yaw_tolerance_rad = 0.006;
  Duration settle = 400ms;         ///< Standstill between two moves, which separates their effects.
  Duration final_settle = 1000ms;  ///< Standstill at the end; odometry and truth then agree in time.
  /// If there is no progress for `rest_after`, the course commands zero for `rest`: a base that was stopped ignores an
  /// input until it has been zero (`rearm: neutral`, docs/stop.md).
  Duration rest_after = 1500ms, rest = 1s;
  Duration stall_limit = 5s;  ///< Without progress for this long, the course is aborted.
};

enum class CoursePhase : std::uint8_t { Straight, Turn, Settle, Rest, Done, Stalled };

/// Drives a polygon by closed loop on the pose: a side, a turn in place, the next side. It ends at the start pose.
///
/// The first pose fixes the corners in odom, so errors of one side do not add up over the course.
/// Units: SI. Frame: odom. Threads: one. Allocates: nothing.
class SquareCourse {
 public:
  explicit SquareCourse(const CourseOptions& options);

  /// Returns the next command for the present pose. Call it at a steady rate, e.g. 50 Hz.
  [[nodiscard]] VelocityCommand step(const PlanarPose& pose, MonotonicTime now);

  [[nodiscard]] CoursePhase phase() const { return phase_; }
  [[nodiscard]] bool is_over() const { return phase_ == CoursePhase::Done || phase_ == CoursePhase::Stalled; }
  /// Returns the number of sides driven so far.
  [[nodiscard]] unsigned sides_done() const { return sides_done_; }
  /// Returns the length of the path of the poses, in m.
  [[nodiscard]] double distance_m() const { return distance_m_; }

 private:
  [[nodiscard]] VelocityCommand drive_side(const PlanarPose& pose, double dt_s);
  [[nodiscard]] VelocityCommand turn(const PlanarPose& pose, double dt_s);
  [[nodiscard]] VelocityCommand brake(double dt_s);
  void settle(MonotonicTime now);
  void rest(MonotonicTime now);
  void note_progress(const PlanarPose& pose, MonotonicTime now);

  CourseOptions options_;
  CoursePhase phase_ = CoursePhase::Settle;
  CoursePhase resumes_ = CoursePhase::Straight;  // after a rest
  bool next_is_turn_ = false, rested_ = false;
  unsigned sides_done_ = 0, corrections_ = 0;
  bool started_ = false;
  PlanarPose last_, corner_;  // corner_: start of the present side, heading along it
  double goal_yaw_rad_ = 0;
  VelocityCommand command_;
  MonotonicTime last_step_, rests_since_, progress_at_;
  PlanarPose progress_pose_;
  double distance_m_ = 0;
};

}  // namespace nacelle::drive
