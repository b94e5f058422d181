// SPDX-License-Identifier: Apache-2.0
#include "navsat/model/world_alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace nacelle::navsat {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using spatial::kPi;
using spatial::quaternion_from_rpy;
using spatial::quaternion_from_yaw;
using spatial::yaw_from_quaternion;

TEST(WorldAlignment, the_robot_is_where_it_was_in_both_frames) {
  const RigidTransform X_WB{quaternion_from_yaw(0.4), {3.0, -2.0, 0.1}};
  const Vector3d p_CB{500'000.0, 5'600'000.0, 130.0};
  const Alignment alignment = align(X_WB, p_CB, quaternion_from_yaw(1.3), 0.0);
  EXPECT_LT((alignment.X_WC * p_CB - X_WB.translation_m).norm(), 1e-8);
  // A metre in front of the robot is a metre in front of it.
  const Vector3d ahead_C = p_CB + Vector3d{std::cos(1.3), std::sin(1.3), 0.0};
  const Vector3d ahead_W = X_WB.translation_m + Vector3d{std::cos(0.4), std::sin(0.4), 0.0};
  EXPECT_LT((alignment.X_WC * ahead_C - ahead_W).norm(), 1e-8);
  EXPECT_LT((alignment.X_CW * ahead_W - ahead_C).norm(), 1e-8);
}

TEST(WorldAlignment, roll_and_pitch_do_not_tilt_the_world) {
  const RigidTransform X_WB{quaternion_from_rpy({0.2, -0.1, 0.4}), {0.0, 0.0, 0.0}};
  const Alignment alignment = align(X_WB, {0.0, 0.0, 0.0}, quaternion_from_rpy({-0.3, 0.2, 1.0}), 0.0);
  EXPECT_LT((alignment.X_WC.rotation * Vector3d::UnitZ() - Vector3d::UnitZ()).norm(), 1e-12);
}

// Edinburgh in 2014: magnetic north 2.46 degrees west of true north. robot_localization's example file has +0.0429351 for it
// (params/dual_ekf_navsat_example.yaml, 55.944831 N 3.186998 W); NOAA's calculator says -2.46 degrees.
TEST(WorldAlignment, a_declination_to_the_west_is_positive) {
  // A robot that faces true east stands counter-clockwise of what the compass calls east by the negative declination: its needle
  // points west of north, so the compass says that it looks south of (magnetic) east.
  const double declination_west_rad = 0.0429351;
  const Quaterniond seen_by_compass = quaternion_from_yaw(-declination_west_rad);
  const Quaterniond R_CB = corrected(seen_by_compass, {.declination_rad = declination_west_rad});
  EXPECT_NEAR(yaw_from_quaternion(R_CB), 0.0, 1e-12) << "east";
}

TEST(WorldAlignment, a_compass_that_is_zero_towards_north_needs_half_pi) {
  EXPECT_NEAR(yaw_from_quaternion(corrected(Quaterniond::Identity(), {.yaw_offset_rad = kPi / 2.0})), kPi / 2.0, 1e-12);
}

TEST(WorldAlignment, the_grid_is_turned_by_the_convergence) {
  // East of its zone's meridian, north of the equator, the grid's north lies east of true north: along true north a point comes west
  // of where the grid's north would have it.
  const GeoPoint here{50.0, 11.0, 0.0}, north_of_here{50.001, 11.0, 0.0};
  const auto utm = GeoProjection::utm(here);
  ASSERT_TRUE(utm);
  ASSERT_GT(utm->convergence_rad(), 0.0);
  const Vector3d step = *utm->forward(north_of_here) - *utm->forward(here);
  const double grid_heading_rad = std::atan2(step.y(), step.x());
  const Quaterniond R_CB = corrected(quaternion_from_yaw(kPi / 2.0), {.convergence_rad = utm->convergence_rad()});
  EXPECT_NEAR(yaw_from_quaternion(R_CB), grid_heading_rad, 1e-6);
}

TEST(WorldAlignment, with_a_true_heading_a_world_is_east_north_up) {
  for (const GeoPoint& datum : {GeoPoint{50.0, 11.5, 0.0}, GeoPoint{-35.0, 149.1, 600.0}, GeoPoint{78.2, 15.6, 0.0}}) {
    for (const bool is_local : {false, true}) {
      const auto plane = is_local ? GeoProjection::local(datum) : GeoProjection::utm(datum);
      ASSERT_TRUE(plane);
      const HeadingCorrection correction{.convergence_rad = plane->convergence_rad()};
      const Alignment alignment =
          align({}, *plane->forward(datum), corrected(Quaterniond::Identity(), correction), plane->convergence_rad());
      GeoPoint north = datum;
      north.latitude_deg += 0.001;
      const Vector3d p_W = alignment.X_WC * *plane->forward(north);
      EXPECT_NEAR(p_W.x(), 0.0, 0.02) << datum.latitude_deg;
      EXPECT_NEAR(p_W.y(), 111.3, 0.5);
    }
  }
}

TEST(WorldAlignment, the_antennas_place_is_taken_off) {
  // The robot looks north; the antenna is 0.3 m ahead of it and 0.1 m to its left.
  const Vector3d p = origin_of_base({10.0, 20.0, 1.5}, quaternion_from_yaw(kPi / 2.0), {0.3, 0.1, 0.5});
  EXPECT_LT((p - Vector3d{10.1, 19.7, 1.0}).norm(), 1e-12);
}

TEST(WorldAlignment, covariances_turn_with_the_frames) {
  Eigen::Matrix3d covariance_E = Vector3d{4.0, 1.0, 9.0}.asDiagonal();
  // The world's x axis points north.
  const Alignment alignment = align({}, Vector3d::Zero(), quaternion_from_yaw(kPi / 2.0), 0.0);
  const Eigen::Matrix3d covariance_W = covariance_in_world(alignment, covariance_E);
  EXPECT_NEAR(covariance_W(0, 0), 1.0, 1e-12) << "along north";
  EXPECT_NEAR(covariance_W(1, 1), 4.0, 1e-12);
  const unsigned seed = 7;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> angle{-kPi, kPi};
  covariance_E << 4.0, 0.5, 0.1, 0.5, 1.0, -0.2, 0.1, -0.2, 9.0;
  for (int i = 0; i < 100; ++i) {
    const Alignment any = align({quaternion_from_yaw(angle(random)), {1.0, 2.0, 3.0}}, {4.0, 5.0, 6.0},
                                quaternion_from_yaw(angle(random)), angle(random));
    EXPECT_LT((covariance_of_fix(any, covariance_in_world(any, covariance_E)) - covariance_E).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace nacelle::navsat
