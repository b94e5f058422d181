// SPDX-License-Identifier: Apache-2.0
#include "odometry/model/wheel_odometry.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <vector>

namespace nacelle::odometry {
namespace {

constexpr double kSeparation_m = 0.3;

struct Case {
  double x, y, yaw;
  WheelStep step;
};
std::vector<Case> cases(unsigned seed) {
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> any{-1.0, 1.0};
  std::vector<Case> all{{0, 0, 0, {0, 0}},
                        {0, 0, 0, {0.1, 0.1}},
                        {1, 2, 3, {-0.1, 0.1}},
                        {0, 0, 1, {0.1, 0.1 + 1e-9}},
                        {0, 0, 1, {0.1, 0.1 - 2.9e-7}},
                        {0, 0, 1, {0.1, 0.1 + 3.1e-7}}};
  for (int i = 0; i < 200; ++i) all.push_back({any(random), any(random), 10 * any(random), {any(random), any(random)}});
  for (int i = 0; i < 50; ++i) {  // nearly straight, around the change of formula
    const double d = any(random);
    all.push_back({any(random), any(random), any(random), {d, d + 1e-6 * any(random)}});
  }
  return all;
}

Eigen::Vector3d moved(const Case& c) {
  const Moved to = move(c.x, c.y, c.yaw, c.step, kSeparation_m);
  return {to.x_m, to.y_m, to.yaw_rad};
}

TEST(ArcLaws, one_step_equals_many_small_ones) {
  const unsigned seed = 41;
  for (const Case& c : cases(seed)) {
    Case small = c;
    constexpr int kParts = 1000;
    small.step = {c.step.left_m / kParts, c.step.right_m / kParts};
    for (int i = 0; i < kParts; ++i) {
      const Eigen::Vector3d at = moved(small);
      small.x = at[0];
      small.y = at[1];
      small.yaw = at[2];
    }
    const Eigen::Vector3d once = moved(c);
    EXPECT_NEAR(small.x, once[0], 1e-9) << "seed " << seed;
    EXPECT_NEAR(small.y, once[1], 1e-9);
    EXPECT_NEAR(small.yaw, once[2], 1e-9);
  }
}

TEST(ArcLaws, rolling_back_undoes_rolling_forth) {
  for (const Case& c : cases(42)) {
    const Eigen::Vector3d there = moved(c);
    const Eigen::Vector3d back = moved({there[0], there[1], there[2], {-c.step.left_m, -c.step.right_m}});
    EXPECT_LT((back - Eigen::Vector3d{c.x, c.y, c.yaw}).norm(), 1e-9);
  }
}

TEST(ArcLaws, the_step_does_not_depend_on_where_it_starts) {
  for (const Case& c : cases(43)) {
    const Eigen::Vector3d at_origin = moved({0, 0, 0, c.step});
    const Eigen::Vector2d turned = Eigen::Rotation2Dd{c.yaw} * at_origin.head<2>() + Eigen::Vector2d{c.x, c.y};
    EXPECT_LT((moved(c).head<2>() - turned).norm(), 1e-12);
  }
}

TEST(ArcLaws, the_jacobians_are_the_slopes) {
  const unsigned seed = 44;
  const double h = 1e-7;
  for (const Case& c : cases(seed)) {
    const Moved to = move(c.x, c.y, c.yaw, c.step, kSeparation_m);
    const auto slope = [&](auto change) {
      Case up = c, down = c;
      change(up, h);
      change(down, -h);
      return Eigen::Vector3d{(moved(up) - moved(down)) / (2 * h)};
    };
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", left " << c.step.left_m << ", right " << c.step.right_m);
    EXPECT_LT((slope([](Case& n, double d) { n.x += d; }) - to.by_pose.col(0)).norm(), 1e-6);
    EXPECT_LT((slope([](Case& n, double d) { n.y += d; }) - to.by_pose.col(1)).norm(), 1e-6);
    EXPECT_LT((slope([](Case& n, double d) { n.yaw += d; }) - to.by_pose.col(2)).norm(), 1e-6);
    EXPECT_LT((slope([](Case& n, double d) { n.step.left_m += d; }) - to.by_step.col(0)).norm(), 1e-6);
    EXPECT_LT((slope([](Case& n, double d) { n.step.right_m += d; }) - to.by_step.col(1)).norm(), 1e-6);
  }
}

TEST(Arc, a_quarter_turn_ends_on_the_circle) {
  const double radius = 1.0, quarter = M_PI / 2;
  const Moved to =
      move(0, 0, 0, {quarter * (radius - kSeparation_m / 2), quarter * (radius + kSeparation_m / 2)}, kSeparation_m);
  EXPECT_NEAR(to.x_m, 1.0, 1e-14);
  EXPECT_NEAR(to.y_m, 1.0, 1e-14);
  EXPECT_NEAR(to.yaw_rad, quarter, 1e-14);
}

TEST(CovarianceLaws, it_grows_with_every_step_and_stays_a_covariance) {
  const unsigned seed = 45;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> any{-0.01, 0.01};
  PlanarPose pose;
  double last_det = 0.0;
  for (int i = 0; i < 100'000; ++i) {
    const double before = pose.covariance(2, 2);
    pose = integrate(pose, {any(random), any(random)}, kSeparation_m, {});
    ASSERT_GT(pose.covariance(2, 2), before) << "seed " << seed << ", step " << i;
    ASSERT_EQ(pose.covariance(0, 1), pose.covariance(1, 0));
    if (i % 1000 == 999) {
      const Eigen::LLT<Eigen::Matrix3d> factor{pose.covariance};
      ASSERT_EQ(factor.info(), Eigen::Success) << "seed " << seed << ", step " << i;
      const double det = pose.covariance.determinant();
      ASSERT_GT(det, last_det);
      last_det = det;
    }
  }
}

TEST(Covariance, standing_still_adds_nothing) {
  PlanarPose pose;
  pose.covariance.diagonal() << 1e-6, 1e-6, 1e-6;
  EXPECT_EQ(integrate(pose, {0, 0}, kSeparation_m, {}).covariance, pose.covariance);
}

TEST(Covariance, a_straight_metre_is_as_unsure_as_the_parameter_says) {
  PlanarPose pose;
  const StepNoise noise{1e-4, 1e-4, 0.0};
  for (int i = 0; i < 1000; ++i) pose = integrate(pose, {0.001, 0.001}, kSeparation_m, noise);
  EXPECT_NEAR(pose.covariance(0, 0), 0.5e-4, 1e-9) << "the mean of two wheels of 1e-4 each";
  EXPECT_NEAR(pose.covariance(2, 2), 2e-4 / (kSeparation_m * kSeparation_m), 1e-7);
  EXPECT_NEAR(pose.covariance(1, 1), pose.covariance(2, 2) / 3.0, 1e-5)
      << "a heading that wanders: s^2/3 of its variance";
}

// The covariance is honest: errors drawn from the model have a normalised square (NEES) of one per degree of freedom.
TEST(Covariance, holds_the_errors_of_a_thousand_simulated_drives) {
  const unsigned seed = 46;
  std::mt19937 random{seed};
  std::normal_distribution<double> normal;
  const StepNoise noise;
  double nees = 0.0;
  constexpr int kDrives = 1000;
  for (int drive = 0; drive < kDrives; ++drive) {
    PlanarPose told;
    double x = 0, y = 0, yaw = 0;
    for (int i = 0; i < 400; ++i) {
      // Four sides of a metre, each followed by a quarter turn.
      const bool turning = i % 100 >= 80;
      const double turn_step = M_PI / 2 / 20 * kSeparation_m / 2;
      const WheelStep step = turning ? WheelStep{-turn_step, turn_step} : WheelStep{0.0125, 0.0125};
      told = integrate(told, step, kSeparation_m, noise);
      const WheelStep real{step.left_m + std::sqrt(noise.k_left_m * std::abs(step.left_m)) * normal(random),
                           step.right_m + std::sqrt(noise.k_right_m * std::abs(step.right_m)) * normal(random)};
      const Moved to = move(x, y, yaw, real, kSeparation_m);
      x = to.x_m;
      y = to.y_m;
      yaw = to.yaw_rad + std::sqrt(noise.k_turn_rad * std::abs(turning ? M_PI / 40 : 0.0)) * normal(random);
    }
    const Eigen::Vector3d error{x - told.x_m, y - told.y_m, yaw - told.yaw_rad};
    nees += error.dot(told.covariance.inverse() * error) / 3.0 / kDrives;
  }
  EXPECT_GT(nees, 0.85) << "seed " << seed;
  EXPECT_LT(nees, 1.15) << "seed " << seed;
}

// Wheels as those of the simulated robot: radii off by 0.3 %, track by 1 %, slip of 0.5 % drawn each second.
TEST(Covariance, the_defaults_fit_a_robot_of_ordinary_make) {
  const unsigned seed = 47;
  std::mt19937 random{seed};
  std::normal_distribution<double> normal;
  double nees = 0.0;
  constexpr int kDrives = 500;
  for (int drive = 0; drive < kDrives; ++drive) {
    const double left_scale = 1 + 0.003 * normal(random), right_scale = 1 + 0.003 * normal(random);
    const double track_m = kSeparation_m * (1 + 0.01 * normal(random));
    PlanarPose told;
    double x = 0, y = 0, yaw = 0, left_slip = 0, right_slip = 0;
    for (int i = 0; i < 1000; ++i) {  // 20 s at 50 Hz: four sides of a metre and four turns
      if (i % 50 == 0) {
        left_slip = 0.005 * normal(random);
        right_slip = 0.005 * normal(random);
      }
      const bool turning = i % 250 >= 200;
      const double turn_step = M_PI / 2 / 50 * kSeparation_m / 2;
      const WheelStep step = turning ? WheelStep{-turn_step, turn_step} : WheelStep{0.005, 0.005};
      told = integrate(told, step, kSeparation_m, {});
      const Moved to =
          move(x, y, yaw, {step.left_m * left_scale * (1 - left_slip), step.right_m * right_scale * (1 - right_slip)},
               track_m);
      x = to.x_m;
      y = to.y_m;
      yaw = to.yaw_rad;
    }
    const Eigen::Vector3d error{x - told.x_m, y - told.y_m, yaw - told.yaw_rad};
    nees += error.dot(told.covariance.inverse() * error) / 3.0 / kDrives;
  }
  EXPECT_GT(nees, 0.5) << "seed " << seed;
  EXPECT_LT(nees, 2.0) << "seed " << seed;
}

}  // namespace
}  // namespace nacelle::odometry
