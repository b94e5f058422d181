// SPDX-License-Identifier: Apache-2.0
#include "odometry/model/joint_reader.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

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
    EXPECT_EQ(s.samples,
              s.steps + s.first + s.jumps + s.incomplete + s.not_finite + s.repeated + s.time_jumps + s.gaps);
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
  for (int i = 1; i <= 10; ++i) EXPECT_TRUE(read(1000 + i * 100, 30.0 + i, 30.0 + i));
  EXPECT_FALSE(read(2100, 50.0, 50.0)) << "100 rad/s";
}

TEST_F(JointReaderTest, what_was_measured_at_the_begin_of_a_pause_is_followed_by_a_long_way_and_no_jump) {
  static_cast<void>(read(0, 0.0, 0.0));
  EXPECT_TRUE(read(20, 0.2, 0.2));
  EXPECT_TRUE(read(420, 0.4, 0.4)) << "0.4 s late, and as old";
  EXPECT_TRUE(read(440, 0.6, 0.6));
  const auto step = read(460, 4.6, 4.6);
  ASSERT_TRUE(step);
  EXPECT_NEAR(step->wheels.left_m, 0.4, 1e-12);
  for (int i = 1; i <= 20; ++i) EXPECT_TRUE(read(460 + i * 20, 4.6 + i * 0.2, 4.6 + i * 0.2));
  EXPECT_FALSE(read(880, 0.0, 0.0)) << "a restart is seen all the same";
  EXPECT_EQ(reader_.stats().jumps, 1U);
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

constexpr double kTurn_rad = 2.0 * std::numbers::pi;

/// Two wheels that turn for ten minutes, forwards and backwards, behind an encoder that shows `shown(angle)` at 50 Hz.
struct Drive {
  using Shown = std::function<double(double angle_rad)>;
  enum class Speeds { Told, NotTold };
  /// How much of the way was lost, at its end, as a part of all that was driven.
  static double lost_part(JointReader& reader, const Shown& shown, Speeds speeds = Speeds::NotTold) {
    std::minstd_rand random{42};
    std::normal_distribution<double> jitter{0.0, 0.05};
    const std::string names[] = {"left", "right"};
    double left_rad = 1.0, right_rad = 2.0, way_rad = 0.0, found_rad = 0.0;
    for (int i = 0; i < 30000; ++i) {
      const double base_rps = 5.0 * std::sin(static_cast<double>(i) * 0.0005) + jitter(random);
      if (i > 0) {
        left_rad += base_rps * 0.02;
        right_rad += (base_rps + 0.5) * 0.02;
        way_rad += std::abs(base_rps) * 0.02;
      }
      const double positions[] = {shown(left_rad), shown(right_rad)};
      const double told[] = {base_rps, base_rps + 0.5};
      const auto step = speeds == Speeds::Told ? reader.read(at_ms(std::int64_t{20} * i), names, positions, told)
                                               : reader.read(at_ms(std::int64_t{20} * i), names, positions);
      if (step) found_rad += step->wheels.left_m / 0.1;
    }
    return std::abs(found_rad - (left_rad - 1.0)) / way_rad;
  }
};

double counted(double angle_rad, double step_rad, double range) {
  double count = std::fmod(std::floor(angle_rad / step_rad), range);
  if (count < 0.0) count += range;
  return count * step_rad;
}

struct JointReaderCircle : ::testing::Test {
  static JointReader reader(double range_rad = 0.0) {
    return JointReader{{{"left"}, {"right"}, 0.1, 0.1, 40.0, range_rad}};
  }
};

TEST_F(JointReaderCircle, nothing_is_lost_at_the_ends_of_one_turn) {
  const auto around_zero = [](double angle_rad) { return std::remainder(angle_rad, kTurn_rad); };
  const auto from_zero = [](double angle_rad) { return angle_rad - kTurn_rad * std::floor(angle_rad / kTurn_rad); };
  for (const Drive::Shown& shown : {Drive::Shown{around_zero}, Drive::Shown{from_zero}}) {
    for (const auto speeds : {Drive::Speeds::NotTold, Drive::Speeds::Told}) {
      JointReader found_out = reader(), declared = reader(kTurn_rad);
      EXPECT_LT(Drive::lost_part(found_out, shown, speeds), 1e-9);
      EXPECT_EQ(found_out.stats().jumps, 0U);
      EXPECT_DOUBLE_EQ(found_out.range_rad(true), kTurn_rad);
      EXPECT_LT(Drive::lost_part(declared, shown, speeds), 1e-9);
      EXPECT_EQ(declared.stats().jumps, 0U);
    }
  }
}

TEST_F(JointReaderCircle, nothing_is_lost_at_the_ends_of_a_counter) {
  constexpr double kStep_rad = kTurn_rad / 4096.0;
  const auto shown = [](double angle_rad) { return counted(angle_rad, kStep_rad, 65536.0); };
  JointReader found_out = reader(), declared = reader(65536.0 * kStep_rad);
  EXPECT_LT(Drive::lost_part(found_out, shown), 1e-5) << "one step";
  EXPECT_EQ(found_out.stats().jumps, 0U);
  EXPECT_NEAR(found_out.range_rad(true), 65536.0 * kStep_rad, 1e-6);
  EXPECT_LT(Drive::lost_part(declared, shown), 1e-5);
  EXPECT_EQ(declared.stats().jumps, 0U);
}

TEST_F(JointReaderCircle, slow_samples_need_the_speed_to_find_the_circle_out) {
  JointReader read = reader();
  const std::string names[] = {"left", "right"};
  double found_rad = 0.0;
  for (int i = 0; i <= 50; ++i) {  // 5 rad/s at 5 Hz: 40 rad/s would be 8 rad, more than a turn
    const double angle_rad = std::remainder(1.0 * i, kTurn_rad);
    const double positions[] = {angle_rad, angle_rad};
    const double speeds[] = {5.0, 5.0};
    if (const auto step = read.read(at_ms(std::int64_t{200} * i), names, positions, speeds))
      found_rad += step->wheels.left_m / 0.1;
  }
  EXPECT_NEAR(found_rad, 50.0, 1e-9);
}

TEST_F(JointReaderCircle, an_encoder_that_leaves_the_turn_counts_in_no_circle) {
  JointReader read = reader();
  EXPECT_LT(Drive::lost_part(read, [](double angle_rad) { return angle_rad; }), 1e-9);
  EXPECT_EQ(read.range_rad(true), 0.0);
}

TEST_F(JointReaderCircle, speeds_alone_are_integrated_and_a_long_gap_starts_again) {
  JointReader read = reader();
  const std::string names[] = {"left", "right"};
  const auto at = [&](std::int64_t ms, double left, double right) {
    const double speeds[] = {left, right};
    return read.read(at_ms(ms), names, {}, speeds);
  };
  EXPECT_FALSE(at(0, 1.0, 2.0));
  const auto step = at(100, 2.0, 4.0);
  ASSERT_TRUE(step);
  EXPECT_NEAR(step->wheels.left_m, 0.1 * 0.15, 1e-12) << "the mean of both ends";
  EXPECT_NEAR(step->wheels.right_m, 0.1 * 0.3, 1e-12);
  EXPECT_FALSE(at(5000, 2.0, 4.0));
  EXPECT_EQ(read.stats().gaps, 1U);
  EXPECT_TRUE(at(5100, 2.0, 4.0));
}

}  // namespace
}  // namespace nacelle::odometry
