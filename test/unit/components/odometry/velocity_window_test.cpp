// SPDX-License-Identifier: Apache-2.0
#include "odometry/model/velocity_window.hpp"

#include <gtest/gtest.h>

namespace nacelle::odometry {
namespace {

TEST(VelocityWindow, is_the_mean_of_the_last_steps_by_their_time) {
  VelocityWindow window{2};
  EXPECT_EQ(window.speed_mps(), 0.0);
  window.add(100.0, 100.0, 1.0);
  window.add(0.01, 0.1, 0.02);
  window.add(0.03, 0.1, 0.06);
  EXPECT_DOUBLE_EQ(window.speed_mps(), 0.5);
  EXPECT_DOUBLE_EQ(window.yaw_rate_rps(), 2.5);
  EXPECT_DOUBLE_EQ(window.duration_s(), 0.08);
}

TEST(VelocityWindow, is_exactly_zero_once_all_its_steps_are) {
  VelocityWindow window{3};
  for (int i = 0; i < 1000; ++i) window.add(0.1 * i, 0.3 * i, 0.02);
  for (int i = 0; i < 3; ++i) window.add(0.0, 0.0, 0.02);
  EXPECT_EQ(window.speed_mps(), 0.0);
  EXPECT_EQ(window.yaw_rate_rps(), 0.0);
}

TEST(VelocityWindow, forgets_when_cleared) {
  VelocityWindow window{3};
  window.add(1, 1, 1);
  window.clear();
  EXPECT_EQ(window.speed_mps(), 0.0);
  window.add(1, 1, 2);
  EXPECT_EQ(window.speed_mps(), 0.5);
}

}  // namespace
}  // namespace nacelle::odometry
