// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/truth_topic.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace nacelle::cli {
namespace {

using nlohmann::json;

json pose_of(double x, double y, double half_yaw) {
  return {{"position", {{"x", x}, {"y", y}, {"z", 0.0}}},
          {"orientation", {{"x", 0.0}, {"y", 0.0}, {"z", std::sin(half_yaw)}, {"w", std::cos(half_yaw)}}}};
}

TEST(FloorPose, is_read_with_and_without_a_covariance) {
  const json pose = pose_of(1.5, -2.0, 0.4);
  const json stamped{{"pose", pose}}, with_covariance{{"pose", {{"pose", pose}, {"covariance", json::array()}}}};
  for (const auto& message : {stamped, with_covariance}) {
    const auto read = floor_pose_in(message);
    ASSERT_TRUE(read) << message;
    EXPECT_NEAR(read->x_m, 1.5, 1e-12);
    EXPECT_NEAR(read->y_m, -2.0, 1e-12);
    EXPECT_NEAR(read->yaw_rad, 0.8, 1e-12);
  }
}

TEST(FloorPose, is_nothing_in_another_type) {
  EXPECT_FALSE(floor_pose_in(json::object()));
  EXPECT_FALSE(floor_pose_in({{"pose", 3}}));
  EXPECT_FALSE(floor_pose_in({{"pose", {{"position", {{"x", "far"}}}}}}));
  EXPECT_FALSE(floor_pose_in(json::array({1, 2})));
}

TEST(FloorPose, is_seen_from_another_one) {
  const double quarter = std::numbers::pi / 2.0;
  const FloorPose seen = seen_from({1.0, 2.0, quarter}, {1.0, 3.0, -quarter - 0.1});
  EXPECT_NEAR(seen.x_m, 1.0, 1e-12);
  EXPECT_NEAR(seen.y_m, 0.0, 1e-12);
  EXPECT_NEAR(seen.yaw_rad, std::numbers::pi - 0.1, 1e-12);
}

}  // namespace
}  // namespace nacelle::cli
