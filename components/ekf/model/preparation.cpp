// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/preparation.hpp"

#include <cmath>

namespace nacelle::ekf {
namespace {

constexpr double kMaskLength = 1e-6;    // robot_localization: rows of a rotated mask shorter than this are off
constexpr double kFlatVariance = 1e-6;  // robot_localization, forceTwoD

// Returns the mask of three axes in a rotated frame: an axis is set if a configured axis has a component along it.
unsigned rotated_mask(const Eigen::Matrix3d& R, StateMask mask, int first) {
  unsigned on = 0;
  for (int i = 0; i < 3; ++i) {
    double length_squared = 0.0;
    for (int j = 0; j < 3; ++j) length_squared += has(mask, first + j) ? R(i, j) * R(i, j) : 0.0;
    if (length_squared >= kMaskLength * kMaskLength) on |= 1U << i;
  }
  return on;
}

// What is not configured may hold anything; it must not poison the rest when it is rotated.
Eigen::Vector3d configured_or_zero(Eigen::Vector3d values, StateMask mask, int first) {
  for (int i = 0; i < 3; ++i) {
    if (!has(mask, first + i) && !std::isfinite(values[i])) values[i] = 0.0;
  }
  return values;
}

// Appends `Size` consecutive states whose values and covariance are given; `on` says which.
template <int Size>
Prepared append(const Eigen::Matrix<double, Size, 1>& values, const Eigen::Matrix<double, Size, Size>& covariance,
                unsigned on, int first, const PartSetup& setup, Reading& out) {
  out.rows = 0;
  out.gate = setup.gate;
  std::array<int, Size> from{};
  bool finite = true;
  for (int i = 0; i < Size; ++i) {
    const int state = first + i;
    if ((on >> i & 1U) == 0 || (setup.two_d && has(kFlatStates, state))) continue;
    if (!std::isfinite(values[i])) {
      finite = false;
      continue;
    }
    const auto k = static_cast<std::size_t>(out.rows);
    from[k] = i;
    out.index[k] = static_cast<std::uint8_t>(state);
    out.value[k] = values[i];
    for (std::size_t l = 0; l <= k; ++l) {
      const double c = 0.5 * (covariance(i, from[l]) + covariance(from[l], i));
      if (!std::isfinite(c)) return err(Rejection::Covariance);
      out.covariance[k * kStates + l] = out.covariance[l * kStates + k] = c;
    }
    ++out.rows;
  }
  // An input of z alone says nothing in a flat world but that the world is flat; robot_localization fuses that, too.
  if (out.rows == 0 && (!finite || !setup.two_d)) return err(Rejection::NotFinite);
  if (setup.two_d) {
    for (int i = 0; i < kStates; ++i) {
      if (has(kFlatStates, i)) out.add(static_cast<StateIndex>(i), 0.0, kFlatVariance);
    }
  }
  return {};
}

// A covariance of something that is not configured may be garbage, too.
template <int Size>
Eigen::Matrix<double, Size, Size> cleaned(const Eigen::Matrix<double, Size, Size>& covariance, StateMask mask,
                                          int first) {
  Eigen::Matrix<double, Size, Size> clean = covariance;
  for (int i = 0; i < Size; ++i) {
    for (int j = 0; j < Size; ++j) {
      if ((!has(mask, first + i) || !has(mask, first + j)) && !std::isfinite(clean(i, j))) clean(i, j) = 0.0;
    }
  }
  return clean;
}

// An IMU that faces sideways pitches when the robot rolls; its yaw is the robot's however it is mounted.
Eigen::Matrix3d by_mounting_yaw(const RigidTransform& X_BS) {
  return spatial::matrix_from_rpy({0.0, 0.0, spatial::rpy_from_quaternion(X_BS.rotation).yaw_rad});
}

// Poses and orientations of a differential input: the step since the last one, how long it took and the sum of the covariances.
struct Difference {
  RigidTransform step;
  double dt_s{};
  Matrix6d covariance;
};
Result<Difference, Rejection> difference(PoseMemory& memory, WallTime stamp, const RigidTransform& X_now,
                                         const Matrix6d& covariance) {
  const PoseMemory before = memory;
  memory = {true, stamp, X_now, covariance};
  if (!before.filled) return err(Rejection::First);
  const double dt_s = to_seconds(stamp - before.stamp);
  if (!(dt_s > 0.0)) return err(Rejection::Stale);
  return Difference{before.X.inverse() * X_now, dt_s, (covariance + before.covariance) * dt_s};
}

// The velocity that makes a step; robot_localization takes the chord and the angles.
Vector6d velocity_of(const Difference& d, const PartSetup& setup) {
  if (!setup.rotations_of_robot_localization) return twist_of(d.step) / d.dt_s;
  const auto turn = spatial::rpy_from_quaternion(d.step.rotation);
  Vector6d twist;
  twist << d.step.translation_m, turn.roll_rad, turn.pitch_rad, turn.yaw_rad;
  return twist / d.dt_s;
}

PartSetup of_velocities(const PartSetup& poses, unsigned mask) {
  PartSetup velocities = poses;
  velocities.mask = static_cast<StateMask>((mask & kPoseMask) << kVx);
  return velocities;
}

}  // namespace

Prepared prepare_pose(const RigidTransform& X_MB, const Matrix6d& covariance, const RigidTransform& X_WM,
                      const PartSetup& setup, Reading& out) {
  RigidTransform known = X_MB;
  known.translation_m = configured_or_zero(X_MB.translation_m, setup.mask, kX);
  const RigidTransform X_WB = X_WM * known;
  const Eigen::Matrix3d R = X_WM.rotation.toRotationMatrix();
  const auto rpy = spatial::rpy_from_quaternion(X_WB.rotation);
  Vector6d values;
  values << X_WB.translation_m, rpy.roll_rad, rpy.pitch_rad, rpy.yaw_rad;
  const unsigned on = rotated_mask(R, setup.mask, kX) | rotated_mask(R, setup.mask, kRoll) << 3U;
  return append<6>(values, spatial::rotate_covariance(R, cleaned<6>(covariance, setup.mask, kX)), on, kX, setup, out);
}

Prepared prepare_twist(const Vector6d& twist_S, const Matrix6d& covariance, const RigidTransform& X_BS,
                       const Eigen::Vector3d& w_B, const PartSetup& setup, Reading& out) {
  const Eigen::Matrix3d R = X_BS.rotation.toRotationMatrix();
  Vector6d values;
  // The sensor's own motion w x p is not the base's: v_B = R v_S + p x w.
  values << R * configured_or_zero(twist_S.head<3>(), setup.mask, kVx) + X_BS.translation_m.cross(w_B),
      R * configured_or_zero(twist_S.tail<3>(), setup.mask, kVroll);
  const unsigned on = rotated_mask(R, setup.mask, kVx) | rotated_mask(R, setup.mask, kVroll) << 3U;
  return append<6>(values, spatial::rotate_covariance(R, cleaned<6>(covariance, setup.mask, kVx)), on, kVx, setup, out);
}

Eigen::Quaterniond base_orientation(const Eigen::Quaterniond& q_WS, const RigidTransform& X_BS,
                                    const PartSetup& setup) {
  return setup.rotations_of_robot_localization ? base_orientation_by_angles(q_WS, X_BS.rotation)
                                               : base_orientation(q_WS, X_BS.rotation);
}

Prepared prepare_orientation(const Eigen::Quaterniond& q_WB, const Eigen::Matrix3d& covariance,
                             const RigidTransform& X_BS, const PartSetup& setup, Reading& out) {
  const auto rpy = spatial::rpy_from_quaternion(q_WB);
  const Eigen::Matrix3d R = by_mounting_yaw(X_BS);
  const Eigen::Matrix3d turned = spatial::rotate_covariance(R, cleaned<3>(covariance, setup.mask, kRoll));
  return append<3>({rpy.roll_rad, rpy.pitch_rad, rpy.yaw_rad}, turned, rotated_mask(R, setup.mask, kRoll), kRoll, setup,
                   out);
}

Prepared prepare_acceleration(const Eigen::Vector3d& a_S, const Eigen::Matrix3d& covariance,
                              const Eigen::Vector3d& gravity_S, const RigidTransform& X_BS, const Turning& turning,
                              const PartSetup& setup, Reading& out) {
  const Eigen::Matrix3d R = X_BS.rotation.toRotationMatrix();
  const Eigen::Vector3d& p = X_BS.translation_m;
  const Eigen::Vector3d& w = turning.w_B;
  // A point p of a turning body is accelerated by alpha x p + w x (w x p) more than its origin.
  const Eigen::Vector3d gravity = setup.rotations_of_robot_localization ? gravity_S : R * gravity_S;
  const Eigen::Vector3d values =
      R * configured_or_zero(a_S, setup.mask, kAx) - gravity - turning.alpha_B.cross(p) - w.cross(w.cross(p));
  const Eigen::Matrix3d turned = spatial::rotate_covariance(R, cleaned<3>(covariance, setup.mask, kAx));
  return append<3>(values, turned, rotated_mask(R, setup.mask, kAx), kAx, setup, out);
}

Prepared prepare_difference(PoseMemory& memory, WallTime stamp, const RigidTransform& X_now, const Matrix6d& covariance,
                            const RigidTransform& X_BS, const Eigen::Vector3d& w_B, const PartSetup& setup,
                            Reading& out) {
  auto d = difference(memory, stamp, X_now, covariance);
  if (!d) return err(d.error());
  // Poses carry their covariance along the axes of the world they are given in; the step is along the body's.
  if (!setup.rotations_of_robot_localization)
    d->covariance =
        spatial::rotate_covariance(Eigen::Matrix3d{X_now.rotation.toRotationMatrix().transpose()}, d->covariance);
  return prepare_twist(velocity_of(*d, setup), d->covariance, X_BS, w_B, of_velocities(setup, setup.mask), out);
}

Prepared prepare_turn(PoseMemory& memory, WallTime stamp, const Eigen::Quaterniond& q_WB,
                      const Eigen::Matrix3d& covariance, const RigidTransform& X_BS, const PartSetup& setup,
                      Reading& out) {
  const Eigen::Matrix3d R = by_mounting_yaw(X_BS);
  Matrix6d turned = Matrix6d::Zero();
  turned.bottomRightCorner<3, 3>() = spatial::rotate_covariance(R, cleaned<3>(covariance, setup.mask, kRoll));
  const auto d = difference(memory, stamp, {q_WB, Eigen::Vector3d::Zero()}, turned);
  if (!d) return err(d.error());
  const unsigned mask = rotated_mask(R, setup.mask, kRoll) << static_cast<unsigned>(kRoll);
  return prepare_twist(velocity_of(*d, setup), d->covariance, {}, Eigen::Vector3d::Zero(), of_velocities(setup, mask),
                       out);
}

RigidTransform relative_to_first(PoseMemory& memory, const RigidTransform& X_now) {
  if (!memory.filled) {
    memory.filled = true;
    memory.X = X_now;
  }
  return memory.X.inverse() * X_now;
}

Result<Eigen::Quaterniond, Rejection> rotation_from(double x, double y, double z, double w) {
  const double length_squared = x * x + y * y + z * z + w * w;
  if (!std::isfinite(length_squared)) return err(Rejection::NotFinite);
  if (length_squared == 0.0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond{w, x, y, z}.normalized();
}

}  // namespace nacelle::ekf
