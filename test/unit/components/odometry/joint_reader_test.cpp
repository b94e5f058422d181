// SPDX-License-Identifier: Apache-2.0
#include "odometry/model/joint_reader.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nacelle::odometry {
namespace {

WallTime at_ms(std::int64_t ms) { return WallTime{Duration{ms * 1'000'000}}; }

class JointReaderTest : public ::testing::Test {
 protected:
  std::optional<JointReader::Step> read(std::int64_t ms, double left, double right) {
    const std::string names[] = {"right", "camera_pan", "left"};
    const double positions[] = {right, 99.0, left};
    return reader_.read(at_ms(ms), names, positions);
  }
  void expect_counts_add_up() {
    const auto& s = reader_.stats();
    EXPECT_EQ(s.samples, s.steps + s.first + s.jumps + s.incomplete + s.not_finite + s.repeated + s.time_jumps);
  }
  JointReader reader_{{{"left"}, {"right"}, 0.1, 0.2, 40.0}};
};

TEST_F(JointReaderTest, the_first_sample_only_starts_the_differences) {
  EXPECT_FALSE(read(0, 1000.0, -500.0));
  const auto step = read(20, 1000.1, -500.2);
  ASSERT_TRUE(step);
  EXPECT_NEAR(step->wheels.left_m, 0.01, 1e-12);
  EXPECT_NEAR(step->wheels.right_m, -0.04, 1e-12);
  EXPECT_NEAR(step->dt_s, 0.02, 1e-12);
  expect_counts_add_up();
}

TEST_F(JointReaderTest, a_restarted_board_is_a_jump_and_not_a_motion) {
  static_cast<void>(read(0, 30.0, 30.0));
  static_cast<void>(read(20, 30.1, 30.1));
  EXPECT_FALSE(read(40, 0.0, 0.0));
  const auto after = read(60, 0.1, 0.1);
  ASSERT_TRUE(after) << "it goes on from the new numbers";
  EXPECT_NEAR(after->wheels.left_m, 0.01, 1e-12);
  EXPECT_EQ(reader_.stats().jumps, 1U);
  expect_counts_add_up();
}

TEST_F(JointReaderTest, a_long_gap_may_hold_a_long_way) {
  static_cast<void>(read(0, 0.0, 0.0));
  EXPECT_TRUE(read(1000, 30.0, 30.0));
  EXPECT_FALSE(read(1100, 35.0, 35.0)) << "50 rad/s";
}

TEST_F(JointReaderTest, what_is_not_usable_is_counted_and_left_out) {
  static_cast<void>(read(0, 0.0, 0.0));
  const std::string names[] = {"left", "right"};
  const std::string others[] = {"left", "arm"};
  const double one[] = {1.0};
  const double two[] = {0.1, 0.1};
  EXPECT_FALSE(reader_.read(at_ms(10), names, one));
  EXPECT_FALSE(reader_.read(at_ms(10), others, two));
  EXPECT_FALSE(reader_.read(at_ms(10), {}, {}));
  EXPECT_FALSE(read(10, std::nan(""), 0.0));
  EXPECT_FALSE(read(0, 0.0, 0.0));
  EXPECT_EQ(reader_.stats().incomplete, 3U);
  EXPECT_EQ(reader_.stats().not_finite, 1U);
  EXPECT_EQ(reader_.stats().repeated, 1U);
  EXPECT_TRUE(read(20, 0.1, 0.1));
  expect_counts_add_up();
}

TEST_F(JointReaderTest, a_clock_that_was_set_back_starts_again) {
  static_cast<void>(read(1000, 5.0, 5.0));
  EXPECT_FALSE(read(500, 5.1, 5.1));
  EXPECT_TRUE(read(520, 5.2, 5.2));
  EXPECT_EQ(reader_.stats().time_jumps, 1U);
  expect_counts_add_up();
}

TEST(JointReaderSides, the_mean_of_a_sides_wheels_counts_wherever_their_names_stand) {
  JointReader reader{{{"fl", "rl"}, {"fr", "rr"}, 0.1, 0.1, 40.0}};
  const std::string names[] = {"rr", "rl", "fr", "fl"};
  const std::string shuffled[] = {"fl", "fr", "rl", "rr"};
  const double zero[] = {0, 0, 0, 0};
  const double some[] = {0.1, 0.3, 0.2, 0.5};  // fl 0.1, fr 0.3, rl 0.2, rr 0.5
  EXPECT_FALSE(reader.read(at_ms(0), names, zero));
  const auto step = reader.read(at_ms(20), shuffled, some);
  ASSERT_TRUE(step);
  EXPECT_NEAR(step->wheels.left_m, 0.1 * 0.15, 1e-12);
  EXPECT_NEAR(step->wheels.right_m, 0.1 * 0.4, 1e-12);
}

}  // namespace
}  // namespace nacelle::odometry
