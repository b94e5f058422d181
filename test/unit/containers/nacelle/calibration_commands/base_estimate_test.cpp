// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/base_estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "driven_base.hpp"

namespace nacelle::calibration {
namespace {

#ifdef NACELLE_SANITIZED
constexpr int kSeeds = 1;  // a fit takes fifty times as long
#else
constexpr int kSeeds = 11;
#endif

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

#ifndef NACELLE_SANITIZED
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
#endif

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

TEST(BaseEstimate, a_base_that_does_not_slip_gets_a_slip_below_the_measurement_but_not_none) {
  const auto found = estimate_base(nominal_base(), nominal_base(), by_topic(3, kNoSlip, 2, 1.0), {0.001, 0.001});
  ASSERT_TRUE(found && found->slip);
  // A quarter of (1 mm)^2 and (1 mrad)^2 after 1 m at least.
  EXPECT_GE(found->slip->distance_m, 0.24e-6);
  EXPECT_LE(found->slip->distance_m, 1e-6);
  EXPECT_GE(found->slip->heading_per_m, 0.24e-6);
  EXPECT_LE(found->slip->heading_per_m, 1e-6);
  EXPECT_GT(found->slip->heading_per_rad, 0.0);
  const auto by_tape = estimate_base(nominal_base(), nominal_base(), by_hand(3, kNoSlip, 5, 1.0), {0.003, 0.01});
  ASSERT_TRUE(by_tape && by_tape->slip);
  EXPECT_GT(by_tape->slip->heading_per_m, 0.0);
  EXPECT_LT(by_tape->slip->heading_per_m, 1e-5);
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

}  // namespace
}  // namespace nacelle::calibration
