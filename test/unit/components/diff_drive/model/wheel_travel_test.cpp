// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/wheel_travel.hpp"

#include <gtest/gtest.h>

namespace nacelle::diff_drive {
namespace {

WheelReading at(double left_rad, double right_rad) { return {{}, true, left_rad, right_rad}; }
constexpr MonotonicTime kStart{100s};

TEST(WheelTravel, starts_at_the_boards_own_count) {
  WheelTravel travel{{}};
  travel.advance(at(7.0, -3.0), kStart);
  EXPECT_EQ(travel.left_rad(), 7.0);
  EXPECT_EQ(travel.right_rad(), -3.0);
}

TEST(WheelTravel, continues_across_a_counter_that_wraps) {
  WheelTravel travel{{.wrap_rad = 1000.0}};
  travel.advance(at(499.0, -499.0), kStart);
  travel.advance(at(-499.0, 499.0), kStart + 20ms);
  EXPECT_NEAR(travel.left_rad(), 501.0, 1e-9);
  EXPECT_NEAR(travel.right_rad(), -501.0, 1e-9);
  EXPECT_EQ(travel.restarts(), 0U);
}

TEST(WheelTravel, ignores_the_jump_of_a_board_that_restarts) {
  WheelTravel travel{{.max_wheel_rate_rps = 10.0, .slack_rad = 1.0}};
  travel.advance(at(90.0, 90.0), kStart);
  travel.advance(at(90.1, 90.1), kStart + 20ms);
  travel.advance(at(0.0, 0.0), kStart + 40ms);
  travel.advance(at(0.1, 0.1), kStart + 60ms);
  EXPECT_NEAR(travel.left_rad(), 90.2, 1e-9);
  EXPECT_EQ(travel.restarts(), 1U);
}

TEST(WheelTravel, believes_a_large_step_after_a_long_gap_of_frames) {
  WheelTravel travel{{.max_wheel_rate_rps = 10.0, .slack_rad = 1.0}};
  travel.advance(at(0.0, 0.0), kStart);
  travel.advance(at(15.0, 15.0), kStart + 1s);
  EXPECT_NEAR(travel.left_rad(), 15.0, 1e-9);
}

TEST(WheelTravel, takes_no_step_across_a_pause) {
  WheelTravel travel{{}};
  travel.advance(at(1.0, 1.0), kStart);
  travel.pause();
  travel.advance(at(2.0, 2.0), kStart + 1s);
  travel.advance(at(2.5, 2.5), kStart + 2s);
  EXPECT_NEAR(travel.left_rad(), 1.5, 1e-9);
}

TEST(WheelTravel, integrates_speeds_where_there_are_no_positions) {
  WheelTravel travel{{}};
  for (int i = 0; i <= 50; ++i) travel.advance({{2.0, -1.0}}, kStart + i * 20ms);
  EXPECT_NEAR(travel.left_rad(), 2.0, 1e-9);
  EXPECT_NEAR(travel.right_rad(), -1.0, 1e-9);
}

TEST(WheelTravel, a_capture_time_never_runs_backward) {
  WheelTravel travel{{}};
  travel.advance(at(0.0, 0.0), kStart + 20ms);
  travel.advance(at(0.1, 0.1), kStart + 10ms);
  EXPECT_EQ(travel.captured_at(), kStart + 20ms);
}

}  // namespace
}  // namespace nacelle::diff_drive
