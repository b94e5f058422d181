// SPDX-License-Identifier: Apache-2.0
#include "drive/model/path_track.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nacelle::drive {
namespace {

WallTime at(Duration since) { return WallTime{1'000s} + since; }

/// A robot that goes along x at 1 m/s and turns at 1 rad/s, read each 20 ms for 10 s.
PathTrack straight_run() {
  PathTrack track;
  for (int i = 0; i <= 500; ++i) track.note_truth({at(i * 20ms), {i * 0.02, 0.0, i * 0.02}});
  return track;
}

TEST(PathTrack, compares_a_pose_with_the_truth_at_its_own_stamp) {
  PathTrack track = straight_run();
  track.add(10.0, StampedPose{at(9'910ms), {9.91, 0.03, 9.91 - 2 * M_PI}}, StampedPose{at(9'950ms), {9.99, 0.0, 9.90}});
  const auto sample = track.samples().at(0);
  EXPECT_DOUBLE_EQ(sample.truth.x_m, 10.0);
  EXPECT_DOUBLE_EQ(sample.odometry.x_m, 9.91);
  EXPECT_NEAR(sample.odometry_error.distance_m, 0.03, 1e-9) << "not the 9 cm that the robot went on meanwhile";
  EXPECT_NEAR(sample.odometry_error.yaw_deg, 0.0, 1e-9) << "the truth counts turns";
  EXPECT_NEAR(sample.ekf_error.distance_m, 0.04, 1e-9);
  EXPECT_NEAR(sample.ekf_error.yaw_deg, 0.05 * 180 / M_PI, 1e-9);
}

TEST(PathTrack, has_no_error_of_a_pose_that_is_unknown_or_too_old) {
  PathTrack track = straight_run();
  track.add(10.0, std::nullopt, StampedPose{at(4'000ms), {4.0, 0.0, 0.0}});
  const auto sample = track.samples().at(0);
  EXPECT_TRUE(std::isnan(sample.odometry.x_m));
  EXPECT_TRUE(std::isnan(sample.odometry_error.distance_m));
  EXPECT_DOUBLE_EQ(sample.ekf.x_m, 4.0);
  EXPECT_TRUE(std::isnan(sample.ekf_error.distance_m));
}

TEST(PathTrack, has_a_path_without_a_truth) {
  PathTrack track;
  track.add(0.0, StampedPose{at(0ms), {1.0, 2.0, 0.0}}, std::nullopt);
  EXPECT_FALSE(track.has_truth());
  const auto sample = track.samples().at(0);
  EXPECT_TRUE(std::isnan(sample.truth.x_m));
  EXPECT_DOUBLE_EQ(sample.odometry.y_m, 2.0);
  EXPECT_TRUE(std::isnan(sample.odometry_error.distance_m));
}

TEST(PathTrack, compares_a_stamp_just_after_the_newest_truth_with_that) {
  PathTrack track = straight_run();
  track.add(10.0, std::nullopt, StampedPose{at(10'001ms), {10.0, 0.0, 10.0}});
  EXPECT_NEAR(track.samples().at(0).ekf_error.distance_m, 0.0, 1e-9);
}

TEST(ErrorBetween, has_the_shorter_way_round) {
  EXPECT_NEAR(error_between({0, 0, M_PI - 0.1}, {3, 4, -M_PI + 0.1}).yaw_deg, 0.2 * 180 / M_PI, 1e-9);
  EXPECT_NEAR(error_between({0, 0, 0}, {3, 4, 0}).distance_m, 5.0, 1e-12);
}

}  // namespace
}  // namespace nacelle::drive
