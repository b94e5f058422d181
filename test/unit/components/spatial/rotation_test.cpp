// SPDX-License-Identifier: Apache-2.0
#include "nacelle/spatial/rotation.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace nacelle::spatial {
namespace {

std::vector<double> angle_cases(unsigned seed) {
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> any{-50.0, 50.0};
  std::vector<double> cases{0.0, 1e-8, -1e-8, kPi, -kPi, std::nextafter(kPi, 4.0), 3 * kPi, -3 * kPi};
  for (int i = 0; i < 200; ++i) cases.push_back(any(random));
  return cases;
}

Eigen::Quaterniond random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond{normal(random), normal(random), normal(random), normal(random)}.normalized();
}

TEST(AngleLaws, wrapping_keeps_the_direction_and_lies_in_the_half_open_turn) {
  const unsigned seed = 7;
  for (const double a : angle_cases(seed)) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", angle " << a);
    const double w = wrap_to_pi(a);
    EXPECT_NEAR(std::cos(w), std::cos(a), 1e-12);
    EXPECT_NEAR(std::sin(w), std::sin(a), 1e-12);
    EXPECT_GT(w, -kPi);
    EXPECT_LE(w, kPi);
    EXPECT_EQ(wrap_to_pi(w), w);
  }
}

TEST(AngleLaws, wrapping_does_not_hide_what_is_not_finite) {
  EXPECT_TRUE(std::isnan(wrap_to_pi(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_TRUE(std::isnan(wrap_to_pi(std::numeric_limits<double>::infinity())));
}

TEST(AngleLaws, the_shortest_turn_arrives) {
  for (const double from : angle_cases(8)) {
    for (const double to : {0.0, 3.1, -3.1, 1.5})
      EXPECT_NEAR(std::cos(from + shortest_turn(from, to) - to), 1.0, 1e-12);
  }
}

TEST(RotationLaws, roll_pitch_yaw_round_trips_through_the_quaternion) {
  const unsigned seed = 9;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> turn{-kPi, kPi};
  std::uniform_real_distribution<double> pitch{-1.57, 1.57};
  for (int i = 0; i < 500; ++i) {
    const RollPitchYaw a{turn(random), pitch(random), turn(random)};
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", case " << i);
    const auto b = rpy_from_quaternion(quaternion_from_rpy(a));
    EXPECT_NEAR(shortest_turn(a.roll_rad, b.roll_rad), 0.0, 1e-9);
    EXPECT_NEAR(a.pitch_rad, b.pitch_rad, 1e-9);
    EXPECT_NEAR(shortest_turn(a.yaw_rad, b.yaw_rad), 0.0, 1e-9);
  }
}

TEST(RotationLaws, fixed_axes_mean_roll_first_and_yaw_last) {
  const RollPitchYaw a{0.3, -0.4, 2.0};
  const Eigen::Matrix3d R = (Eigen::AngleAxisd{a.yaw_rad, Eigen::Vector3d::UnitZ()} *
                             Eigen::AngleAxisd{a.pitch_rad, Eigen::Vector3d::UnitY()} *
                             Eigen::AngleAxisd{a.roll_rad, Eigen::Vector3d::UnitX()})
                                .toRotationMatrix();
  EXPECT_LT((quaternion_from_rpy(a).toRotationMatrix() - R).norm(), 1e-14);
  EXPECT_LT((matrix_from_rpy(a) - R).norm(), 1e-14);
}

TEST(RotationLaws, at_the_pole_the_angles_still_give_the_same_rotation) {
  for (const double pole : {0.5 * kPi, -0.5 * kPi}) {
    for (const double yaw : {-2.0, 0.0, 1.0, 3.1}) {
      for (const double roll : {0.0, 0.7}) {
        const auto q = quaternion_from_rpy({roll, pole, yaw});
        const auto back = quaternion_from_rpy(rpy_from_quaternion(q));
        EXPECT_NEAR(std::abs(q.dot(back)), 1.0, 1e-12) << "pitch " << pole << " yaw " << yaw << " roll " << roll;
      }
    }
  }
}

TEST(RotationLaws, yaw_of_a_flat_rotation_is_its_angle) {
  for (const double a : angle_cases(10)) {
    EXPECT_NEAR(shortest_turn(a, yaw_from_quaternion(quaternion_from_yaw(a))), 0.0, 1e-12) << a;
  }
}

TEST(Slerp, agrees_with_the_constant_rate_turn_at_every_distance) {
  const unsigned seed = 11;
  std::mt19937 random{seed};
  for (const double angle : {0.0, 1e-9, 1e-4, 0.05, 0.25, 0.2829, 0.29, 1.0, 3.0}) {
    for (int i = 0; i < 20; ++i) {
      const auto from = random_rotation(random);
      const auto axis = random_rotation(random) * Eigen::Vector3d::UnitX();
      const auto to = from * Eigen::Quaterniond{Eigen::AngleAxisd{angle, axis}};
      for (const double ratio : {0.0, 0.1, 0.5, 0.9, 1.0}) {
        const auto expected = from * Eigen::Quaterniond{Eigen::AngleAxisd{ratio * angle, axis}};
        const auto got = slerp(from, to, ratio);
        SCOPED_TRACE(::testing::Message() << "seed " << seed << ", angle " << angle << ", ratio " << ratio);
        EXPECT_LT((got.coeffs() - expected.coeffs()).norm(), 1e-13);
        EXPECT_NEAR(got.norm(), 1.0, 1e-13);
      }
    }
  }
}

TEST(Slerp, takes_the_short_way_when_the_signs_differ) {
  const auto from = quaternion_from_yaw(0.1);
  auto to = quaternion_from_yaw(0.3);
  to.coeffs() *= -1.0;
  EXPECT_NEAR(yaw_from_quaternion(slerp(from, to, 0.5)), 0.2, 1e-12);
}

}  // namespace
}  // namespace nacelle::spatial
