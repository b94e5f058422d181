// SPDX-License-Identifier: Apache-2.0
#include "navsat/component/navsat_inputs.hpp"

#include <cmath>

namespace nacelle::navsat {

NavsatInputs::Taken NavsatInputs::refuse(InputCounters& counters, Refusal cause) {
  ++counters.refused[static_cast<std::size_t>(cause)];
  return err(cause);
}

NavsatInputs::Taken NavsatInputs::take(const sensor_msgs::msg::NavSatFix& message) {
  using sensor_msgs::msg::NavSatFix;
  ++stats.fixes.received;
  const FixReading reading{.has_fix = message.status.status != sensor_msgs::msg::NavSatStatus::STATUS_NO_FIX,
                           .point = {message.latitude, message.longitude, message.altitude},
                           .covariance_m2 = square_of<3>(message.position_covariance),
                           .has_covariance = message.position_covariance_type != NavSatFix::COVARIANCE_TYPE_UNKNOWN};
  const auto checked = check_fix(reading, rules_);
  if (!checked) return refuse(stats.fixes, checked.error());
  ++stats.fixes.used;
  if (checked->covariance_was_unknown) ++stats.unknown_covariance;
  if (fix_is_new_) ++stats.overtaken;
  if (!fix_) fix_.emplace();
  fix_->value = *checked;
  fix_->stamp = time_of(message.header.stamp);
  fix_->frame = message.header.frame_id;
  fix_is_new_ = true;
  return {};
}

void NavsatInputs::refuse_fix(Refusal cause) {
  --stats.fixes.used;
  static_cast<void>(refuse(stats.fixes, cause));
  forget_fix();
}

NavsatInputs::Taken NavsatInputs::take(const nav_msgs::msg::Odometry& message) {
  ++stats.odometry.received;
  if (message.header.frame_id.empty() || message.child_frame_id.empty())
    return refuse(stats.odometry, Refusal::NoFrame);
  const auto& pose = message.pose.pose;
  const Eigen::Vector3d position{pose.position.x, pose.position.y, pose.position.z};
  const Eigen::Quaterniond rotation{pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z};
  if (!position.allFinite() || !rotation.coeffs().allFinite()) return refuse(stats.odometry, Refusal::NotFinite);
  const double norm = rotation.norm();
  if (std::abs(norm - 1.0) > 0.1) return refuse(stats.odometry, Refusal::NoOrientation);
  ++stats.odometry.used;
  if (!pose_) pose_.emplace();
  pose_->X_WB = {Eigen::Quaterniond{rotation.coeffs() / norm}, position};
  pose_->position_covariance_m2 = square_of<6>(message.pose.covariance).topLeftCorner<3, 3>();
  pose_->stamp = time_of(message.header.stamp);
  pose_->world_frame = message.header.frame_id;
  pose_->base_frame = message.child_frame_id;
  pose_is_new_ = true;
  return {};
}

NavsatInputs::Taken NavsatInputs::take(const sensor_msgs::msg::Imu& message) {
  ++stats.imu.received;
  const auto& q = message.orientation;
  const auto R_ES = check_orientation({q.w, q.x, q.y, q.z}, message.orientation_covariance);
  if (!R_ES) return refuse(stats.imu, R_ES.error());
  ++stats.imu.used;
  if (!heading_) heading_.emplace();
  heading_->R_ES = *R_ES;
  heading_->frame = message.header.frame_id;
  return {};
}

}  // namespace nacelle::navsat
