// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/input.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace nacelle::ekf {
namespace {

constexpr StateMask kOrientationMask = mask_of(kRoll) | mask_of(kPitch) | mask_of(kYaw);
constexpr StateMask kRateMask = mask_of(kVroll) | mask_of(kVpitch) | mask_of(kVyaw);

struct PartKind {
  const char* word;
  StateMask states;
};
// In the order in which robot_localization handles them.
std::array<PartKind, 3> kinds_of(InputKind kind) {
  switch (kind) {
    case InputKind::Odometry: return {{{"pose", kPoseMask}, {"twist", kTwistMask}, {"", 0}}};
    case InputKind::Pose: return {{{"pose", kPoseMask}, {"", 0}, {"", 0}}};
    case InputKind::Twist: return {{{"twist", kTwistMask}, {"", 0}, {"", 0}}};
    case InputKind::Imu: break;
  }
  return {
      {{"orientation", kOrientationMask}, {"angular_velocity", kRateMask}, {"linear_acceleration", kAccelerationMask}}};
}

Matrix6d matrix_of(const std::array<double, 36>& values) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(values.data());
}
Eigen::Matrix3d matrix_of(const std::array<double, 9>& values) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
}
Eigen::Vector3d vector_of(const geometry_msgs::msg::Vector3& v) { return {v.x, v.y, v.z}; }

// sensor_msgs/Imu: -1 in the first place says that the field is not there.
bool is_absent(const std::array<double, 9>& covariance) { return std::abs(covariance[0] + 1.0) < 1e-9; }

Matrix6d lower_right(const Eigen::Matrix3d& covariance) {
  Matrix6d all = Matrix6d::Zero();
  all.bottomRightCorner<3, 3>() = covariance;
  return all;
}

void put(const Eigen::Vector3d& v, std::array<double, 3>& into) { into = {v.x(), v.y(), v.z()}; }

void see_wheels(const Vector6d& twist_S, const RigidTransform& X_BS, Witness& out) {
  const Eigen::Vector3d w_B = X_BS.rotation * twist_S.tail<3>();
  out.source = Witness::Source::Wheels;
  put(X_BS.rotation * twist_S.head<3>() + X_BS.translation_m.cross(w_B), out.linear);
  put(w_B, out.angular);
}

void see_imu(const sensor_msgs::msg::Imu& message, const RigidTransform& X_BS, Witness& out) {
  out.source = Witness::Source::Imu;
  out.has_force = !is_absent(message.linear_acceleration_covariance);
  put(out.has_force ? Eigen::Vector3d{X_BS.rotation * vector_of(message.linear_acceleration)}
                    : Eigen::Vector3d{0, 0, 0},
      out.linear);
  put(X_BS.rotation * vector_of(message.angular_velocity), out.angular);
}

}  // namespace

std::uint16_t Input::parts_of(const InputOptions& options) {
  std::uint16_t count = 0;
  for (const PartKind& kind : kinds_of(options.kind)) count += (options.config & kind.states) != 0 ? 1 : 0;
  return count;
}

Input::Input(const InputOptions& options, const InputContext& context, std::uint16_t first_part)
    : options_(options), context_(context) {
  for (const PartKind& kind : kinds_of(options.kind)) {
    const auto mask = static_cast<StateMask>(options.config & kind.states);
    if (mask != 0) parts_.push_back({options.name + " " + kind.word, first_part++, mask});
  }
}

const Input::Part* Input::part(StateMask mask) const {
  for (const Part& p : parts_) {
    if ((p.mask & mask) != 0) return &p;
  }
  return nullptr;
}

void Input::forget() { memory_ = {}; }

void Input::comes_from(std::uint64_t writer, std::uint64_t sequence) {
  auto known = std::ranges::find(heard_, writer, &Heard::writer);
  if (known == heard_.end()) {
    known = std::prev(heard_.end());  // the one whose last message is oldest
    *known = {writer, sequence};
  }
  if (sequence > known->sequence + 1) lost_ += sequence - known->sequence - 1;
  known->sequence = sequence;
  std::rotate(heard_.begin(), known, std::next(known));
}

Result<RigidTransform, Rejection> Input::transform(std::string_view target, std::string_view source, WallTime stamp) {
  if (source.starts_with('/')) source.remove_prefix(1);
  if (target == source) return RigidTransform{};
  auto found = context_.buffer->lookup(target, source, stamp);
  if (!found) found = context_.buffer->lookup_latest(target, source);
  if (found) return found->X_TS;
  last_fault_ = found.error();
  return err(Rejection::NoTransform);
}

void Input::take(const nav_msgs::msg::Odometry& message) {
  begin_message();
  const WallTime stamp = time_of(message.header.stamp);
  take_pose(stamp, {message.header.frame_id, message.child_frame_id, &message.pose});
  take_twist(stamp, or_base(message.child_frame_id), message.twist);
}
void Input::take(const geometry_msgs::msg::PoseWithCovarianceStamped& message) {
  begin_message();
  take_pose(time_of(message.header.stamp), {message.header.frame_id, {}, &message.pose});
}
void Input::take(const geometry_msgs::msg::TwistWithCovarianceStamped& message) {
  begin_message();
  take_twist(time_of(message.header.stamp), or_base(message.header.frame_id), message.twist);
}

void Input::take_pose(WallTime stamp, const PoseIn& in) {
  const Part* const p = part(kPoseMask);
  if (p == nullptr) return;
  context_.filter->offer(p->number, stamp, now_, [&](Reading& out) {
    out.witness.teaches_bias = options_.teaches_gyro_bias;
    return prepare(stamp, in, out);
  });
}

Prepared Input::prepare(WallTime stamp, const PoseIn& in, Reading& out) {
  const Part& p = *part(kPoseMask);
  const auto& pose = in.pose->pose;
  const auto rotation = rotation_from(pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w);
  if (!rotation) return err(rotation.error());
  RigidTransform X_MB{*rotation, {pose.position.x, pose.position.y, pose.position.z}};
  const Matrix6d covariance = matrix_of(in.pose->covariance);
  const PartSetup how = setup(p.mask, options_.pose_gate);
  if (options_.pose_use_child_frame && !in.child.empty()) {
    // The message is the pose of its child. The base's pose follows from the child's mounting.
    const auto X_CB = transform(in.child, context_.options->base_link_frame, stamp);
    if (!X_CB) return err(X_CB.error());
    if (how.rotations_of_robot_localization)
      return prepare_as_robot_localization(stamp, in, {X_MB, *X_CB, covariance}, out);
    X_MB = X_MB * *X_CB;
  }
  if (options_.differential) {
    return prepare_difference(memory_, stamp, X_MB, covariance, {}, Eigen::Vector3d::Zero(), how, out);
  }
  const auto X_WM = transform(context_.options->world_frame,
                              in.frame.empty() ? std::string_view{context_.options->world_frame} : in.frame, stamp);
  if (!X_WM) return err(X_WM.error());
  if (options_.relative) X_MB = relative_to_first(memory_, X_MB);
  return prepare_pose(X_MB, covariance, *X_WM, how, out);
}

// A pose of a child frame as robot_localization takes it: it turns the covariance by the child's mounting, and the difference of two poses is
// the child's velocity. Source: RosFilter::preparePose, steps 5b, 7a to 7e and 7g.
Prepared Input::prepare_as_robot_localization(WallTime stamp, const PoseIn& in, const ChildPose& child, Reading& out) {
  const PartSetup how = setup(part(kPoseMask)->mask, options_.pose_gate);
  const Matrix6d covariance =
      spatial::rotate_covariance(Eigen::Matrix3d{child.X_CB.rotation.toRotationMatrix().transpose()}, child.covariance);
  if (options_.differential) {
    return prepare_difference(memory_, stamp, child.X_MC, covariance, child.X_CB.inverse(),
                              context_.filter->turning().w_B, how, out);
  }
  const auto X_WM = transform(context_.options->world_frame,
                              in.frame.empty() ? std::string_view{context_.options->world_frame} : in.frame, stamp);
  if (!X_WM) return err(X_WM.error());
  RigidTransform X_MB = child.X_MC * child.X_CB;
  if (options_.relative) X_MB = relative_to_first(memory_, X_MB);
  return prepare_pose(X_MB, covariance, *X_WM, how, out);
}

void Input::take_twist(WallTime stamp, std::string_view frame, const geometry_msgs::msg::TwistWithCovariance& twist) {
  const Part* const p = part(kTwistMask);
  if (p == nullptr) return;
  context_.filter->offer(p->number, stamp, now_, [&](Reading& out) -> Prepared {
    const auto X_BS = transform(context_.options->base_link_frame, frame, stamp);
    if (!X_BS) return err(X_BS.error());
    Vector6d values;
    values << vector_of(twist.twist.linear), vector_of(twist.twist.angular);
    out.witness.teaches_bias = options_.teaches_gyro_bias;
    if (options_.witness == Witness::Source::Wheels) see_wheels(values, *X_BS, out.witness);
    return prepare_twist(values, matrix_of(twist.covariance), *X_BS, context_.filter->turning().w_B,
                         setup(p->mask, options_.twist_gate), out);
  });
}

void Input::take(const sensor_msgs::msg::Imu& message) {
  begin_message();
  const WallTime stamp = time_of(message.header.stamp);
  Filter& filter = *context_.filter;
  if (const Part* const p = part(kOrientationMask)) {
    filter.offer(p->number, stamp, now_, [&](Reading& out) { return prepare_imu_orientation(message, stamp, out); });
  }
  if (const Part* const p = part(kRateMask)) {
    filter.offer(p->number, stamp, now_, [&](Reading& out) -> Prepared {
      if (is_absent(message.angular_velocity_covariance)) return err(Rejection::Absent);
      const auto X_BS = transform(context_.options->base_link_frame, or_base(message.header.frame_id), stamp);
      if (!X_BS) return err(X_BS.error());
      Vector6d values = Vector6d::Zero();
      values.tail<3>() = vector_of(message.angular_velocity);
      if (options_.witness == Witness::Source::Imu) see_imu(message, *X_BS, out.witness);
      return prepare_twist(values, lower_right(matrix_of(message.angular_velocity_covariance)), *X_BS,
                           Eigen::Vector3d::Zero(), setup(p->mask, options_.twist_gate), out);
    });
  }
  if (const Part* const p = part(kAccelerationMask)) {
    filter.offer(p->number, stamp, now_, [&](Reading& out) { return prepare_imu_acceleration(message, stamp, out); });
  }
}

Prepared Input::prepare_imu_orientation(const sensor_msgs::msg::Imu& message, WallTime stamp, Reading& out) {
  if (is_absent(message.orientation_covariance)) return err(Rejection::Absent);
  const auto X_BS = transform(context_.options->base_link_frame, or_base(message.header.frame_id), stamp);
  if (!X_BS) return err(X_BS.error());
  const auto& q = message.orientation;
  const auto q_WS = rotation_from(q.x, q.y, q.z, q.w);
  if (!q_WS) return err(q_WS.error());
  const Eigen::Matrix3d covariance = matrix_of(message.orientation_covariance);
  const PartSetup how = setup(part(kOrientationMask)->mask, options_.pose_gate);
  Eigen::Quaterniond q_WB = base_orientation(*q_WS, *X_BS, how);
  if (options_.differential) { return prepare_turn(memory_, stamp, q_WB, covariance, *X_BS, how, out); }
  if (options_.relative) q_WB = relative_to_first(memory_, {q_WB, Eigen::Vector3d::Zero()}).rotation;
  return prepare_orientation(q_WB, covariance, *X_BS, how, out);
}

Prepared Input::prepare_imu_acceleration(const sensor_msgs::msg::Imu& message, WallTime stamp, Reading& out) {
  if (is_absent(message.linear_acceleration_covariance)) return err(Rejection::Absent);
  const auto X_BS = transform(context_.options->base_link_frame, or_base(message.header.frame_id), stamp);
  if (!X_BS) return err(X_BS.error());
  Eigen::Vector3d gravity_S = Eigen::Vector3d::Zero();
  if (options_.remove_gravitational_acceleration) {
    Eigen::Quaterniond q_WS;
    if (is_absent(message.orientation_covariance)) {
      const StateVector& x = context_.filter->belief().mean;
      q_WS = spatial::quaternion_from_rpy({x[kRoll], x[kPitch], x[kYaw]}) * X_BS->rotation;
    } else {
      const auto& q = message.orientation;
      const auto told = rotation_from(q.x, q.y, q.z, q.w);
      if (!told) return err(told.error());
      q_WS = *told;
    }
    gravity_S = q_WS.conjugate() * Eigen::Vector3d{0.0, 0.0, context_.options->gravity_mps2};
    // robot_localization takes the attitude of a relative input for one that begins level.
    if (context_.options->robot_localization_rotations && options_.relative &&
        !is_absent(message.orientation_covariance))
      gravity_S = X_BS->rotation.conjugate() * gravity_S;
  }
  return prepare_acceleration(vector_of(message.linear_acceleration), matrix_of(message.linear_acceleration_covariance),
                              gravity_S, *X_BS, context_.filter->turning(),
                              setup(part(kAccelerationMask)->mask, options_.acceleration_gate), out);
}

}  // namespace nacelle::ekf
