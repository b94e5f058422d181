// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/rotations.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "ekf/model/preparation.hpp"

namespace nacelle::ekf {
namespace {

using spatial::kPi;

constexpr unsigned kRotationSeed = 4601;

Eigen::Vector3d any_vector(std::mt19937& random, double most) {
  std::uniform_real_distribution<double> any{-most, most};
  return {any(random), any(random), any(random)};
}
Eigen::Quaterniond rotation_by(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  return Eigen::Quaterniond{
      Eigen::AngleAxisd{angle, angle > 0.0 ? Eigen::Vector3d{turn / angle} : Eigen::Vector3d::UnitX()}};
}
double degrees_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return turn_vector(a.conjugate() * b).norm() * 180.0 / kPi;
}
double said_of(const Reading& r, StateIndex state) {
  for (std::size_t k = 0; k < static_cast<std::size_t>(r.rows); ++k) {
    if (r.index[k] == state) return r.value[k];
  }
  return std::nan("");
}

TEST(TurnVector, is_the_inverse_of_the_rotation_by_a_vector) {
  std::mt19937 random{kRotationSeed};
  for (const double size : {0.0, 1e-12, 1e-8, 1e-4, 0.3, 1.0, 1.8}) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d turn = any_vector(random, size);
      if (turn.norm() >= kPi) continue;
      Eigen::Quaterniond q = rotation_by(turn);
      if (i % 2 == 1) q.coeffs() = -q.coeffs();  // the same rotation
      EXPECT_LT((turn_vector(q) - turn).norm(), 1e-12 + 1e-15 * size)
          << "seed " << kRotationSeed << " case " << i << " size " << size;
    }
  }
}

TEST(TwistOf, a_body_that_moves_with_the_twist_makes_the_step) {
  std::mt19937 random{kRotationSeed};
  for (const double size : {0.0, 1e-9, 1e-5, 9.9e-3, 1.01e-2, 0.3, 1.5}) {
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d v = any_vector(random, 2.0);
      const Eigen::Vector3d w = any_vector(random, size);
      RigidTransform X;
      constexpr int kSteps = 250;
      for (int k = 0; k < kSteps; ++k) {  // the midpoint's heading: an error of second order
        const Eigen::Quaterniond half = X.rotation * rotation_by(w / (2.0 * kSteps));
        X.translation_m += half * v / kSteps;
        X.rotation = (X.rotation * rotation_by(w / kSteps)).normalized();
      }
      const Vector6d twist = twist_of(X);
      EXPECT_LT((twist.head<3>() - v).norm(), 2e-5) << "seed " << kRotationSeed << " case " << i << " size " << size;
      EXPECT_LT((twist.tail<3>() - w).norm(), 1e-9) << "seed " << kRotationSeed << " case " << i << " size " << size;
    }
  }
}

TEST(BaseOrientation, is_exact_for_every_mounting_and_differences_of_angles_are_not) {
  std::mt19937 random{kRotationSeed};
  double most_exact = 0.0, most_by_angles = 0.0, most_level = 0.0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Quaterniond q_BS = rotation_by(any_vector(random, 0.2));  // up to 20 degrees askew
    const Eigen::Quaterniond q_WB = spatial::quaternion_from_rpy(
        {0.15 * any_vector(random, 1.0).x(), 0.15 * any_vector(random, 1.0).y(), any_vector(random, 3.0).z()});
    most_exact = std::max(most_exact, degrees_between(base_orientation(q_WB * q_BS, q_BS), q_WB));
    most_by_angles = std::max(most_by_angles, degrees_between(base_orientation_by_angles(q_WB * q_BS, q_BS), q_WB));
    const Eigen::Quaterniond level = spatial::quaternion_from_yaw(any_vector(random, 3.0).z());
    most_level = std::max(most_level, degrees_between(base_orientation_by_angles(q_WB * level, level), q_WB));
  }
  EXPECT_LT(most_exact, 1e-9);
  EXPECT_GT(most_by_angles, 1.5) << "robot_localization's way loses degrees";
  EXPECT_LT(most_level, 1.3) << "what is left of a mounting by yaw is of second order in roll and pitch";
}

TEST(PrepareTurn, a_tilted_imu_on_a_base_that_turns_about_its_z_axis_gives_yaw_rate_alone) {
  const RigidTransform X_BS{spatial::quaternion_from_rpy({0.3, -0.2, 0.4}), {0.1, 0.0, 0.2}};
  const WallTime start{10s};
  for (const bool by_angles : {false, true}) {
    const PartSetup setup{.mask = kPoseMask, .rotations_of_robot_localization = by_angles};
    PoseMemory memory;
    Reading r;
    for (int k = 0; k < 2; ++k) {
      const Eigen::Quaterniond q_WS = spatial::quaternion_from_yaw(1.0 + 0.2 * k) * X_BS.rotation;
      const auto done = prepare_turn(memory, start + k * 100ms, base_orientation(q_WS, X_BS, setup),
                                     Eigen::Matrix3d::Identity(), X_BS, setup, r);
      EXPECT_EQ(done.has_value(), k == 1);
    }
    EXPECT_NEAR(said_of(r, kVyaw), 2.0, 1e-9);
    EXPECT_NEAR(said_of(r, kVroll), 0.0, 1e-9);
    EXPECT_NEAR(said_of(r, kVpitch), 0.0, 1e-9);
  }
}

TEST(PrepareTurn, a_base_that_rolls_is_seen_to_roll_by_a_tilted_imu) {
  const RigidTransform X_BS{spatial::quaternion_from_rpy({0.3, -0.2, 0.4}), {}};
  const WallTime start{10s};
  std::array<double, 2> roll_rate{}, pitch_rate{};
  for (const bool by_angles : {false, true}) {
    const PartSetup setup{.mask = kPoseMask, .rotations_of_robot_localization = by_angles};
    PoseMemory memory;
    Reading r;
    for (int k = 0; k < 2; ++k) {
      const Eigen::Quaterniond q_WS = spatial::quaternion_from_rpy({0.05 * k, 0.0, 1.0}) * X_BS.rotation;
      static_cast<void>(prepare_turn(memory, start + k * 100ms, base_orientation(q_WS, X_BS, setup),
                                     Eigen::Matrix3d::Identity(), X_BS, setup, r));
    }
    roll_rate[by_angles ? 1 : 0] = said_of(r, kVroll);
    pitch_rate[by_angles ? 1 : 0] = said_of(r, kVpitch);
  }
  EXPECT_NEAR(roll_rate[0], 0.5, 1e-9);
  EXPECT_NEAR(pitch_rate[0], 0.0, 1e-9);
  EXPECT_GT(std::hypot(roll_rate[1] - 0.5, pitch_rate[1]), 0.01) << "the switch keeps what robot_localization loses";
}

TEST(PrepareDifference, an_arc_has_no_sideways_velocity_as_a_rotation) {
  const double v = 1.0, w = 1.5, dt = 0.1;
  const auto at = [&](double t) {
    return RigidTransform::planar(v / w * std::sin(w * t), v / w * (1.0 - std::cos(w * t)), w * t);
  };
  const WallTime start{10s};
  std::array<double, 2> sideways{};
  for (const bool by_angles : {false, true}) {
    const PartSetup setup{.mask = kPoseMask, .rotations_of_robot_localization = by_angles};
    PoseMemory memory;
    Reading r;
    for (int k = 0; k < 2; ++k)
      static_cast<void>(prepare_difference(memory, start + k * 100ms, at(3.0 + k * dt), Matrix6d::Identity(), {},
                                           Eigen::Vector3d::Zero(), setup, r));
    sideways[by_angles ? 1 : 0] = said_of(r, kVy);
    EXPECT_NEAR(said_of(r, kVx), v, by_angles ? 5e-3 : 1e-9);
    EXPECT_NEAR(said_of(r, kVyaw), w, 1e-9);
  }
  EXPECT_NEAR(sideways[0], 0.0, 1e-9);
  EXPECT_NEAR(sideways[1], 0.5 * w * dt * v, 1e-3) << "the chord, seen from the first heading";
}

TEST(PrepareAcceleration, gravity_is_subtracted_along_the_axes_of_the_sensor) {
  const RigidTransform X_BS{spatial::quaternion_from_rpy({0.0, 0.3, 0.0}), {}};
  const Eigen::Vector3d gravity_S = X_BS.rotation.conjugate() * Eigen::Vector3d{0.0, 0.0, 9.81};  // level and at rest
  Reading r;
  const PartSetup exact{.mask = kAccelerationMask};
  ASSERT_TRUE(prepare_acceleration(gravity_S, Eigen::Matrix3d::Identity(), gravity_S, X_BS, {}, exact, r));
  EXPECT_NEAR(said_of(r, kAx), 0.0, 1e-12);
  EXPECT_NEAR(said_of(r, kAz), 0.0, 1e-12);
  PartSetup as_robot_localization = exact;
  as_robot_localization.rotations_of_robot_localization = true;
  ASSERT_TRUE(
      prepare_acceleration(gravity_S, Eigen::Matrix3d::Identity(), gravity_S, X_BS, {}, as_robot_localization, r));
  EXPECT_NEAR(said_of(r, kAx), -gravity_S.x(), 1e-12) << "a robot at rest accelerates";
}

}  // namespace
}  // namespace nacelle::ekf
