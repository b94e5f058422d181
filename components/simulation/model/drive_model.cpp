// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/drive_model.hpp"

namespace nacelle::simulation {
namespace {
constexpr std::uint64_t kGeometryStream = 1, kSlipStream = 2;
}

DriveModel::DriveModel(const WorldSettings& settings, const Room& room)
    : settings_(settings),
      room_(room),
      geometry_draws_(settings.seed, kGeometryStream),
      slip_draws_(settings.seed, kSlipStream) {
  const auto& nominal = settings.robot;
  const auto& errors = settings.errors;
  geometry_.left_radius_m = nominal.wheel_radius_m * (1.0 + geometry_draws_.normal(errors.wheel_radius));
  geometry_.right_radius_m = nominal.wheel_radius_m * (1.0 + geometry_draws_.normal(errors.wheel_radius));
  geometry_.track_m = nominal.track_m * (1.0 + geometry_draws_.normal(errors.track));
  const auto& known = settings.known;
  if (known.left_radius) geometry_.left_radius_m = nominal.wheel_radius_m * (1.0 + *known.left_radius);
  if (known.right_radius) geometry_.right_radius_m = nominal.wheel_radius_m * (1.0 + *known.right_radius);
  if (known.track) geometry_.track_m = nominal.track_m * (1.0 + *known.track);
  left_.slip = slip_draws_.normal(errors.slip);
  right_.slip = slip_draws_.normal(errors.slip);
}

void DriveModel::step(double dt_s, double left_target_rps, double right_target_rps) {
  since_slip_s_ += dt_s;
  if (since_slip_s_ >= 1.0 - 1e-9) {
    since_slip_s_ -= 1.0;
    left_.slip = slip_draws_.normal(settings_.errors.slip);
    right_.slip = slip_draws_.normal(settings_.errors.slip);
  }
  // First-order lag, exact for a target that stays over the step.
  const double keeps = std::exp(-dt_s / settings_.robot.motor_time_constant_s);
  left_.rate_rps = left_target_rps + (left_.rate_rps - left_target_rps) * keeps;
  right_.rate_rps = right_target_rps + (right_.rate_rps - right_target_rps) * keeps;
  left_.angle_rad += left_.rate_rps * dt_s;
  right_.angle_rad += right_.rate_rps * dt_s;

  const double left_mps = left_.rate_rps * geometry_.left_radius_m * (1.0 - left_.slip);
  const double right_mps = right_.rate_rps * geometry_.right_radius_m * (1.0 - right_.slip);
  double speed_mps = 0.5 * (left_mps + right_mps);
  const double yaw_rate_before_rps = yaw_rate_rps_;
  yaw_rate_rps_ = (right_mps - left_mps) / geometry_.track_m;
  yaw_acceleration_rps2_ = (yaw_rate_rps_ - yaw_rate_before_rps) / dt_s;

  // Exact arc of constant speed and yaw rate, as a chord at the middle yaw; sin(h)/h is 1 below 1e-6 to 1 part in 1e12.
  const double half_rad = 0.5 * yaw_rate_rps_ * dt_s;
  const double chord_m = speed_mps * dt_s * (std::abs(half_rad) < 1e-6 ? 1.0 : std::sin(half_rad) / half_rad);
  const double x_m = pose_.x_m + chord_m * std::cos(pose_.yaw_rad + half_rad);
  const double y_m = pose_.y_m + chord_m * std::sin(pose_.yaw_rad + half_rad);
  const double clearance_m = room_.clearance_m(x_m, y_m);
  // A wall stops the body but not the wheels, which then slide; moving away from it is always possible.
  if (clearance_m < settings_.robot.body_radius_m && clearance_m < room_.clearance_m(pose_.x_m, pose_.y_m)) {
    ++contacts_;
    speed_mps = 0.0;
  } else {
    pose_.x_m = x_m;
    pose_.y_m = y_m;
  }
  pose_.yaw_rad += yaw_rate_rps_ * dt_s;
  acceleration_mps2_ = (speed_mps - speed_mps_) / dt_s;
  speed_mps_ = speed_mps;
}

}  // namespace nacelle::simulation
