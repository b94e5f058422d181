// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/base_estimate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <vector>

#include "driven_base.hpp"

namespace nacelle::calibration {
namespace {

constexpr SlipNoise kNoSlip{0.0, 0.0, 0.0};
constexpr SlipNoise kLittleSlip{2.5e-6, 2.5e-5, 2.5e-5};  // 1.6 mm and 0.29 degrees after a metre
constexpr SlipNoise kMuchSlip{1e-5, 1e-4, 1e-4};          // 3.2 mm and 0.57 degrees
constexpr int kSeeds = 11;

BaseGeometry real_base() {
  BaseGeometry base = nominal_base();
  base.left_radius_multiplier = 1.021;
  base.right_radius_multiplier = 1.013;
  base.separation_multiplier = 0.964;
  return base;
}

/// What an operator measures: a line, and the ends of squares each way, to 3 mm.
std::vector<DrivenWay> by_hand(std::uint64_t seed, const SlipNoise& slip, int squares, double side_m) {
  DrivenBase base{real_base(), slip, seed};
  std::vector<DrivenWay> ways;
  base.begin();
  base.straight(4.0);
  ways.push_back(base.way(Measured::Distance, 0.003));
  for (const bool is_left : {false, true}) {
    for (int i = 0; i < squares; ++i) {
      base.begin();
      base.square(side_m, is_left);
      ways.push_back(base.way(Measured::Position, 0.003));
    }
  }
  return ways;
}

/// What another localisation measures: where each leg ends, to 1 mm and 1 mrad.
std::vector<DrivenWay> by_topic(std::uint64_t seed, const SlipNoise& slip, int squares, double side_m) {
  DrivenBase base{real_base(), slip, seed};
  std::vector<DrivenWay> ways;
  for (const bool is_left : {false, true}) {
    for (int leg = 0; leg < 4 * squares; ++leg) {
      base.begin();
      base.straight(side_m);
      ways.push_back(base.way(Measured::Pose, 0.001, 0.001));
      base.begin();
      base.turn(is_left ? 1.5708 : -1.5708);
      ways.push_back(base.way(Measured::Pose, 0.001, 0.001));
    }
  }
  return ways;
}

void expect_real(const BaseEstimate& found, double relative) {
  const BaseGeometry real = real_base();
  EXPECT_NEAR(found.base.left_radius_multiplier / real.left_radius_multiplier, 1.0, relative);
  EXPECT_NEAR(found.base.right_radius_multiplier / real.right_radius_multiplier, 1.0, relative);
  EXPECT_NEAR(found.base.separation_multiplier / real.separation_multiplier, 1.0, relative);
}

TEST(BaseEstimate, squares_both_ways_and_a_line_find_a_base_that_does_not_slip) {
  const auto found = estimate_base(nominal_base(), nominal_base(), by_hand(1, kNoSlip, 1, 1.0), {0.003, 0.01});
  ASSERT_TRUE(found);
  expect_real(*found, 0.003);
  EXPECT_FALSE(found->slip) << "two numbers too many tell no noise";
  EXPECT_LT(found->rms_after_m, 0.006);
  EXPECT_GT(found->rms_before_m, 0.1);
}

TEST(BaseEstimate, five_squares_of_2_m_each_way_by_hand_are_within_half_a_per_cent) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const auto found = estimate_base(nominal_base(), nominal_base(), by_hand(seed, kLittleSlip, 5, 2.0), {0.003, 0.01});
    ASSERT_TRUE(found);
    expect_real(*found, 0.005);
    ASSERT_TRUE(found->slip);
  }
}

TEST(BaseEstimate, squares_of_1_m_by_a_topic_are_within_half_a_per_cent) {
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const auto found = estimate_base(nominal_base(), nominal_base(), by_topic(seed, kMuchSlip, 2, 1.0), {0.001, 0.001});
    ASSERT_TRUE(found);
    expect_real(*found, 0.005);
  }
}

TEST(BaseEstimate, its_own_uncertainty_covers_its_errors) {
  // 95 % of three numbers of each seed within two standard deviations; fewer than 80 % would be no uncertainty.
  int inside = 0, all = 0;
  const BaseGeometry real = real_base();
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto found = estimate_base(nominal_base(), nominal_base(), by_topic(seed, kMuchSlip, 1, 1.0), {0.001, 0.001});
    ASSERT_TRUE(found) << "seed " << seed;
    const auto count = [&](double multiplier, double right, double stddev) {
      ++all;
      inside += std::abs(multiplier / right - 1.0) < 2.0 * stddev ? 1 : 0;
    };
    count(found->base.left_radius_multiplier, real.left_radius_multiplier, found->left_stddev);
    count(found->base.right_radius_multiplier, real.right_radius_multiplier, found->right_stddev);
    count(found->base.separation_multiplier, real.separation_multiplier, found->separation_stddev);
  }
  EXPECT_GT(inside, all * 8 / 10) << inside << " of " << all;
  EXPECT_LT(inside, all) << "an uncertainty that covers everything is too large";
}

TEST(BaseEstimate, the_slip_is_found_within_a_factor_of_two) {
  const SlipNoise real{4e-5, 6e-4, 8e-4};
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const auto found = estimate_base(nominal_base(), nominal_base(), by_topic(seed, real, 5, 1.0), {0.001, 0.001});
    ASSERT_TRUE(found && found->slip);
    EXPECT_NEAR(std::log2(found->slip->distance_m / real.distance_m), 0.0, 1.0);
    EXPECT_NEAR(std::log2(found->slip->heading_per_m / real.heading_per_m), 0.0, 1.0);
    EXPECT_NEAR(std::log2(found->slip->heading_per_rad / real.heading_per_rad), 0.0, 1.0);
  }
}

TEST(BaseEstimate, ways_that_do_not_show_all_of_it_are_refused) {
  const auto fault = [](const std::vector<DrivenWay>& ways) {
    const auto found = estimate_base(nominal_base(), nominal_base(), ways, {0.003, 0.01});
    return found ? std::optional<EstimateFault>{} : found.error();
  };
  EXPECT_EQ(fault({}), EstimateFault::TooFew);
  auto without_line = by_hand(1, kNoSlip, 1, 1.0);
  without_line.erase(without_line.begin());
  EXPECT_EQ(fault(without_line), EstimateFault::NotSeen) << "squares do not show the mean radius";
  DrivenBase base{real_base(), kNoSlip, 1};
  base.begin();
  base.straight(2.0);
  std::vector<DrivenWay> lines(4, base.way(Measured::Distance));
  EXPECT_EQ(fault(lines), EstimateFault::NotSeen);

  auto mixed = by_hand(1, kNoSlip, 2, 1.0);
  mixed[1].x_m += 1.0;
  mixed[2].x_m -= 1.0;
  EXPECT_EQ(fault(mixed), EstimateFault::Contradictory);
  auto feet = by_hand(1, kNoSlip, 1, 1.0);
  feet.front().x_m *= 3.28;
  const auto of_feet = fault(feet);
  ASSERT_TRUE(of_feet);
  EXPECT_TRUE(*of_feet == EstimateFault::Absurd || *of_feet == EstimateFault::Contradictory);
}

// The figures of docs/ekf.md.
TEST(BaseEstimateFigures, errors_over_44_seeds) {
  struct Case {
    const char* name;
    SlipNoise slip;
    int squares;
    double side_m;
    bool is_by_hand;
    double most_rms;  // relative
  };
  const Case cases[] = {{"by hand, 5 squares of 1 m", kLittleSlip, 5, 1.0, true, 0.003},
                        {"by hand, 5 squares of 2 m", kLittleSlip, 5, 2.0, true, 0.003},
                        {"by hand, 5 squares of 2 m, much slip", kMuchSlip, 5, 2.0, true, 0.004},
                        {"by topic, 1 square of 0.5 m", kLittleSlip, 1, 0.5, false, 0.003},
                        {"by topic, 3 squares of 1 m", kLittleSlip, 3, 1.0, false, 0.0015},
                        {"by topic, 3 squares of 1 m, much slip", kMuchSlip, 3, 1.0, false, 0.002}};
  std::printf("%-40s %-24s %-24s within 0.5 %%\n", "RMS, worst in %", "radii", "separation");
  for (const auto& c : cases) {
    double radius_squares = 0.0, separation_squares = 0.0, radius_worst = 0.0, separation_worst = 0.0;
    int within = 0;
    const int seeds = 44;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const auto ways =
          c.is_by_hand ? by_hand(seed, c.slip, c.squares, c.side_m) : by_topic(seed, c.slip, c.squares, c.side_m);
      const MeasurementNoise noise = c.is_by_hand ? MeasurementNoise{0.003, 0.01} : MeasurementNoise{0.001, 0.001};
      const auto found = estimate_base(nominal_base(), nominal_base(), ways, noise);
      ASSERT_TRUE(found) << c.name << ", seed " << seed;
      const BaseGeometry real = real_base();
      const double left = found->base.left_radius_multiplier / real.left_radius_multiplier - 1.0;
      const double right = found->base.right_radius_multiplier / real.right_radius_multiplier - 1.0;
      const double separation = found->base.separation_multiplier / real.separation_multiplier - 1.0;
      radius_squares += (left * left + right * right) / (2 * seeds);
      separation_squares += separation * separation / seeds;
      radius_worst = std::max({radius_worst, std::abs(left), std::abs(right)});
      separation_worst = std::max(separation_worst, std::abs(separation));
      within += std::max({std::abs(left), std::abs(right), std::abs(separation)}) <= 0.005 ? 1 : 0;
    }
    std::printf("%-40s %.3f, %-17.3f %.3f, %-17.3f %d of %d\n", c.name, 100 * std::sqrt(radius_squares),
                100 * radius_worst, 100 * std::sqrt(separation_squares), 100 * separation_worst, within, seeds);
    EXPECT_LT(std::sqrt(std::max(radius_squares, separation_squares)), c.most_rms) << c.name;
  }
}

}  // namespace
}  // namespace nacelle::calibration
