// SPDX-License-Identifier: Apache-2.0
// The filter's uncertainty beside its errors, over 2 s and 10 s: on the simulated world, whose slip, bias and noise the filter is not
// told, and on a recorded drive. `ekf_honesty` prints the same figures; docs/ekf.md has them.
#include <gtest/gtest.h>

#include "honesty/nees.hpp"
#include "support/places.hpp"

namespace nacelle::ekf::honesty {
namespace {

constexpr int kSeeds = 11;

struct Both {
  Honesty position, yaw;
};
Both honesty_over(const std::vector<Drive>& drives, const Setup& setup, double window_s) {
  std::vector<double> position, yaw;
  for (const Drive& drive : drives) {
    const WindowErrors errors = relative_errors(drive, setup, window_s);
    position.insert(position.end(), errors.position.begin(), errors.position.end());
    yaw.insert(yaw.end(), errors.yaw.begin(), errors.yaw.end());
  }
  return {honesty_of(position, 2), honesty_of(yaw, 1)};
}
std::vector<Drive> simulated_drives(bool calibrates_gyro) {
  std::vector<Drive> drives;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    drives.push_back(simulated({.seed = static_cast<std::uint64_t>(seed), .calibrates_gyro = calibrates_gyro}));
  }
  return drives;
}

// The biases and wheels of a seed are the same in all its windows, so there are as many independent errors as seeds.
void expect_in_band(const Both& both, int runs) {
  const Band two = band_of_mean(runs, 2), one = band_of_mean(runs, 1);
  EXPECT_GT(both.position.mean, two.low);
  EXPECT_LT(both.position.mean, two.high);
  EXPECT_GT(both.yaw.mean, one.low);
  EXPECT_LT(both.yaw.mean, one.high);
}

TEST(Honesty, band_is_that_of_chi_squared) {
  EXPECT_NEAR(band_of_mean(11, 1).low, 3.816 / 11, 0.01);  // tables of chi-squared with 11 and 22 degrees of freedom
  EXPECT_NEAR(band_of_mean(11, 1).high, 21.920 / 11, 0.01);
  EXPECT_NEAR(band_of_mean(11, 2).low, 10.982 / 22, 0.01);
  EXPECT_NEAR(band_of_mean(11, 2).high, 36.781 / 22, 0.01);
}

TEST(Honesty, in_the_simulated_world_with_the_bias_of_its_gyro) {
  const auto drives = simulated_drives(false);
  expect_in_band(honesty_over(drives, default_robot(), 2.0), kSeeds);
  expect_in_band(honesty_over(drives, default_robot(), 10.0), kSeeds);
}

// With the bias taken out at rest the yaw is better than the vehicle's limits say. The filter may be too unsure, not too sure.
TEST(Honesty, in_the_simulated_world_with_a_calibrated_gyro) {
  const auto drives = simulated_drives(true);
  for (const double window_s : {2.0, 10.0}) {
    const Both both = honesty_over(drives, default_robot(), window_s);
    EXPECT_GT(both.position.coverage, 0.93);
    EXPECT_GT(both.yaw.coverage, 0.93);
    EXPECT_GT(both.position.mean, 0.2);
    EXPECT_GT(both.yaw.mean, 0.05);
  }
}

TEST(Honesty, of_the_other_process_noise_is_that_of_a_filter_that_knows_nothing) {
  auto setup = default_robot();
  setup.wheeled = false;
  EXPECT_LT(honesty_over(simulated_drives(false), setup, 2.0).position.mean, 0.01);
}

TEST(Honesty, on_a_recorded_drive) {
  const std::vector<Drive> drives{recorded(test::data("plaza1"), "dyaw_drp_rad")};
  ASSERT_EQ(drives[0].wheels.size(), 9657U);
  for (const double window_s : {2.0, 10.0}) {
    const Both both = honesty_over(drives, outdoor_vehicle(), window_s);
    EXPECT_GT(both.position.coverage, 0.9);
    EXPECT_GT(both.yaw.coverage, 0.85);
    EXPECT_GT(both.position.mean, 0.5);
    EXPECT_LT(both.position.mean, 1.6);
    EXPECT_GT(both.yaw.mean, 0.5);
    EXPECT_LT(both.yaw.mean, 1.6);
  }
}

}  // namespace
}  // namespace nacelle::ekf::honesty
