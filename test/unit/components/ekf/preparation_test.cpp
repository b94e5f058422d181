// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/preparation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace nacelle::ekf {
namespace {

using spatial::kPi;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double value_of(const Reading& r, StateIndex state) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(r.rows); ++k) {
    if (r.index[k] == state) return r.value[k];
  }
  return kNan;
}
double variance_of(const Reading& r, StateIndex state) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(r.rows); ++k) {
    if (r.index[k] == state) return r.covariance[k * (kStates + 1)];
  }
  return kNan;
}
bool tells(const Reading& r, StateIndex state) { return !std::isnan(value_of(r, state)); }

const StateMask kVelocity = mask_of(kVx) | mask_of(kVy);
RigidTransform mounted(double x, double y, double z, double yaw) {
  return {spatial::quaternion_from_yaw(yaw), {x, y, z}};
}

TEST(PrepareTwist, a_sensor_on_the_base_is_taken_as_it_is) {
  Vector6d twist;
  twist << 1, 2, 3, 4, 5, 6;
  Reading r;
  ASSERT_TRUE(prepare_twist(twist, Matrix6d::Identity() * 0.5, {}, {0, 0, 0}, {.mask = kVelocity}, r));
  EXPECT_EQ(r.rows, 2);
  EXPECT_EQ(value_of(r, kVx), 1.0);
  EXPECT_EQ(value_of(r, kVy), 2.0);
  EXPECT_EQ(variance_of(r, kVx), 0.5);
}

TEST(PrepareTwist, turns_values_masks_and_covariances_with_the_mounting) {
  Vector6d twist;
  twist << 1, 0, 0, 0, 0, 0;
  Matrix6d covariance = Matrix6d::Identity();
  covariance(0, 0) = 0.25;
  Reading r;
  ASSERT_TRUE(prepare_twist(twist, covariance, mounted(0, 0, 0, kPi / 2), {0, 0, 0}, {.mask = mask_of(kVx)}, r));
  EXPECT_EQ(r.rows, 1);
  EXPECT_NEAR(value_of(r, kVy), 1.0, 1e-12) << "the sensor's x is the base's y";
  EXPECT_NEAR(variance_of(r, kVy), 0.25, 1e-12);
}

TEST(PrepareTwist, takes_the_lever_arm_off) {
  // A sensor 2 m ahead of a base that turns on the spot with 3 rad/s moves sideways with 6 m/s.
  Vector6d twist;
  twist << 0, 6, 0, 0, 0, 3;
  Reading r;
  ASSERT_TRUE(prepare_twist(twist, Matrix6d::Identity(), mounted(2, 0, 0, 0), {0, 0, 3}, {.mask = kVelocity}, r));
  EXPECT_NEAR(value_of(r, kVx), 0.0, 1e-12);
  EXPECT_NEAR(value_of(r, kVy), 0.0, 1e-12);
}

TEST(PrepareTwist, two_d_mode_pins_the_seven_states_that_a_flat_world_has_not) {
  Vector6d twist = Vector6d::Constant(0.5);
  Reading r;
  ASSERT_TRUE(prepare_twist(twist, Matrix6d::Identity(), {}, {0, 0, 0}, {.mask = kTwistMask, .two_d = true}, r));
  EXPECT_EQ(r.rows, 10);
  for (const StateIndex i : {kZ, kRoll, kPitch, kVz, kVroll, kVpitch, kAz}) {
    EXPECT_EQ(value_of(r, i), 0.0);
    EXPECT_EQ(variance_of(r, i), 1e-6);
  }
  EXPECT_EQ(value_of(r, kVx), 0.5);
  EXPECT_EQ(value_of(r, kVyaw), 0.5);
}

TEST(PrepareTwist, garbage_in_what_is_not_configured_does_no_harm) {
  Vector6d twist;
  twist << 1, kNan, kNan, kNan, kNan, kNan;
  Matrix6d covariance = Matrix6d::Constant(kNan);
  covariance(0, 0) = 1.0;
  Reading r;
  ASSERT_TRUE(prepare_twist(twist, covariance, mounted(0, 0, 0, 0.1), {0, 0, 0}, {.mask = mask_of(kVx)}, r));
  EXPECT_NEAR(value_of(r, kVx), std::cos(0.1), 1e-12);
}

TEST(PrepareTwist, garbage_in_what_is_configured_is_named) {
  Vector6d twist = Vector6d::Zero();
  twist[0] = kNan;
  Reading r;
  EXPECT_EQ(prepare_twist(twist, Matrix6d::Identity(), {}, {0, 0, 0}, {.mask = mask_of(kVx)}, r).error(),
            Rejection::NotFinite);
  EXPECT_EQ(prepare_twist(Vector6d::Zero(), Matrix6d::Constant(kNan), {}, {0, 0, 0}, {.mask = mask_of(kVx)}, r).error(),
            Rejection::Covariance);
}

TEST(PreparePose, an_input_of_z_alone_is_refused_in_two_d_mode) {
  Reading reading;
  const PartSetup z_only{.mask = mask_of(kZ), .two_d = true};
  const auto prepared =
      prepare_pose({Eigen::Quaterniond::Identity(), {1, 2, 3}}, Matrix6d::Identity(), {}, z_only, reading);
  ASSERT_TRUE(prepared.has_value());
  ASSERT_EQ(reading.rows, 7);
  for (std::size_t k = 0; k < 7; ++k) {
    EXPECT_TRUE(has(kFlatStates, reading.index[k]));
    EXPECT_EQ(reading.value[k], 0.0);
  }
  const PartSetup x_and_z{.mask = static_cast<StateMask>(mask_of(kX) | mask_of(kZ)), .two_d = true};
  const RigidTransform broken{Eigen::Quaterniond::Identity(), {std::nan(""), 2, 3}};
  EXPECT_EQ(prepare_pose(broken, Matrix6d::Identity(), {}, x_and_z, reading).error(), Rejection::NotFinite);
}

TEST(PreparePose, brings_position_and_heading_into_the_world) {
  const auto X_WM = mounted(10, 0, 0, kPi / 2);
  const auto X_MB = mounted(1, 0, 0, 0.2);
  Reading r;
  ASSERT_TRUE(prepare_pose(X_MB, Matrix6d::Identity(), X_WM, {.mask = kPoseMask}, r));
  EXPECT_EQ(r.rows, 6);
  EXPECT_NEAR(value_of(r, kX), 10.0, 1e-12);
  EXPECT_NEAR(value_of(r, kY), 1.0, 1e-12);
  EXPECT_NEAR(value_of(r, kYaw), kPi / 2 + 0.2, 1e-12);
}

TEST(PrepareOrientation, an_imu_that_faces_sideways_pitches_when_the_robot_rolls) {
  // Mounted with yaw +90 deg; the robot rolls by 0.1 while heading east.
  const auto X_BS = mounted(0, 0, 0.1, kPi / 2);
  const Eigen::Quaterniond q_WS = spatial::quaternion_from_rpy({0.1, 0, 0}) * X_BS.rotation;
  Reading r;
  for (const bool by_angles : {false, true}) {
    const PartSetup setup{.mask = kPoseMask, .rotations_of_robot_localization = by_angles};
    const auto q_WB = base_orientation(q_WS, X_BS, setup);
    ASSERT_TRUE(prepare_orientation(q_WB, Eigen::Matrix3d::Identity() * 0.01, X_BS, setup, r));
    EXPECT_NEAR(value_of(r, kRoll), 0.1, 1e-9);
    EXPECT_NEAR(value_of(r, kPitch), 0.0, 1e-9);
    EXPECT_NEAR(value_of(r, kYaw), 0.0, 1e-9);
  }
}

TEST(PrepareAcceleration, subtracts_gravity_and_the_lever_arm) {
  // 0.5 m ahead, turning with 2 rad/s that grow by 4 rad/s^2: -2 m/s^2 along x, +2 along y; and gravity along z.
  const auto X_BS = mounted(0.5, 0, 0, 0);
  const Turning turning{{0, 0, 2}, {0, 0, 4}};
  Reading r;
  ASSERT_TRUE(prepare_acceleration({-2, 2, 9.81}, Eigen::Matrix3d::Identity(), {0, 0, 9.81}, X_BS, turning,
                                   {.mask = kAccelerationMask}, r));
  EXPECT_NEAR(value_of(r, kAx), 0.0, 1e-12);
  EXPECT_NEAR(value_of(r, kAy), 0.0, 1e-12);
  EXPECT_NEAR(value_of(r, kAz), 0.0, 1e-12);
}

TEST(PrepareDifference, two_poses_make_a_velocity) {
  PoseMemory memory;
  const WallTime start{10s};
  const PartSetup setup{.mask = kPoseMask};
  const Eigen::Vector3d still = Eigen::Vector3d::Zero();
  Reading r;
  EXPECT_EQ(
      prepare_difference(memory, start, mounted(1, 1, 0, kPi / 2), Matrix6d::Identity(), {}, still, setup, r).error(),
      Rejection::First);
  ASSERT_TRUE(prepare_difference(memory, start + 100ms, mounted(1, 1.05, 0, kPi / 2 + 0.02), Matrix6d::Identity(), {},
                                 still, setup, r));
  EXPECT_NEAR(value_of(r, kVx), 0.5, 1e-4) << "north is ahead when one heads north";
  EXPECT_NEAR(value_of(r, kVyaw), 0.2, 1e-9);
  EXPECT_NEAR(variance_of(r, kVx), 0.2, 1e-9) << "(1 + 1) * 0.1 s";
  EXPECT_FALSE(tells(r, kX));
  EXPECT_EQ(
      prepare_difference(memory, start + 100ms, mounted(2, 0, 0, 0), Matrix6d::Identity(), {}, still, setup, r).error(),
      Rejection::Stale);
}

TEST(RelativeToFirst, starts_at_the_origin) {
  PoseMemory memory;
  EXPECT_NEAR(relative_to_first(memory, mounted(5, 5, 0, 1)).translation_m.norm(), 0.0, 1e-12);
  const auto later = relative_to_first(memory, mounted(5 + std::cos(1.0), 5 + std::sin(1.0), 0, 1));
  EXPECT_NEAR(later.translation_m.x(), 1.0, 1e-12);
}

TEST(RotationFrom, mends_what_robot_localization_mends) {
  EXPECT_TRUE(rotation_from(0, 0, 0, 0)->isApprox(Eigen::Quaterniond::Identity()));
  EXPECT_NEAR(rotation_from(0, 0, 0, 1.5)->norm(), 1.0, 1e-15);
  EXPECT_EQ(rotation_from(0, 0, kNan, 1).error(), Rejection::NotFinite);
}

}  // namespace
}  // namespace nacelle::ekf
