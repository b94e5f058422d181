// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "simulation/model/random.hpp"
#include "simulation/model/room.hpp"
#include "simulation/model/world_settings.hpp"

namespace nacelle::simulation {

/// Pose of the base in the world. The yaw is not wrapped: it counts the turns.
struct Pose {
  double x_m{}, y_m{}, yaw_rad{};
};

/// The numbers that only the world knows.
struct TrueGeometry {
  double left_radius_m, right_radius_m, track_m;
};

/// The two wheels on the ground: motors with a lag, true radii and track, slip, and walls that stop the body.
///
/// Wheel angles are what an encoder sees; the ground moves by radius * angle * (1 - slip).
class DriveModel {
 public:
  DriveModel(const WorldSettings& settings, const Room& room);

  /// Moves on by dt with the motors aiming at these wheel rates. Slip is drawn anew at each full second.
  void step(double dt_s, double left_target_rps, double right_target_rps);

  [[nodiscard]] const Pose& pose() const { return pose_; }
  [[nodiscard]] double speed_mps() const { return speed_mps_; }
  [[nodiscard]] double yaw_rate_rps() const { return yaw_rate_rps_; }
  /// Along the body's x axis, in the last step.
  [[nodiscard]] double acceleration_mps2() const { return acceleration_mps2_; }
  /// In the last step.
  [[nodiscard]] double yaw_acceleration_rps2() const { return yaw_acceleration_rps2_; }
  [[nodiscard]] double left_angle_rad() const { return left_.angle_rad; }
  [[nodiscard]] double right_angle_rad() const { return right_.angle_rad; }
  [[nodiscard]] const TrueGeometry& geometry() const { return geometry_; }
  [[nodiscard]] double left_slip() const { return left_.slip; }
  [[nodiscard]] double right_slip() const { return right_.slip; }
  /// Steps in which a wall held the body.
  [[nodiscard]] std::uint64_t contacts() const { return contacts_; }

 private:
  struct Wheel {
    double rate_rps{}, angle_rad{}, slip{};
  };

  const WorldSettings settings_;
  const Room& room_;
  Random geometry_draws_, slip_draws_;
  TrueGeometry geometry_;
  Wheel left_, right_;
  Pose pose_;
  double speed_mps_ = 0.0, yaw_rate_rps_ = 0.0, acceleration_mps2_ = 0.0, yaw_acceleration_rps2_ = 0.0;
  double since_slip_s_ = 0.0;
  std::uint64_t contacts_ = 0;
};

}  // namespace nacelle::simulation
