// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/rest.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace nacelle::calibration {
namespace {

/// Readings about a mean that alternate by +-spread on each axis.
RestReadings readings(std::size_t count, const Vector3& rate, double rate_spread, double acceleration_spread) {
  RestReadings all;
  for (std::size_t i = 0; i < count; ++i) {
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    all.rates_rps.push_back({rate[0] + sign * rate_spread, rate[1], rate[2]});
    all.accelerations_mps2.push_back({0.0, 0.0, 9.80665 + sign * acceleration_spread});
  }
  return all;
}

TEST(Rest, mean_and_scatter_are_those_of_the_readings) {
  const std::vector<Vector3> all{{1.0, 2.0, 3.0}, {3.0, 2.0, 9.0}};
  EXPECT_EQ(mean_of(all), (Vector3{2.0, 2.0, 6.0}));
  EXPECT_DOUBLE_EQ(scatter_of(all), 3.0) << "of the worst axis";
  EXPECT_EQ(mean_of({}), Vector3{});
  EXPECT_EQ(scatter_of({}), 0.0);
}

TEST(Rest, accepts_a_still_sensor_with_bias_and_noise) {
  EXPECT_TRUE(check_rest(readings(200, {0.05, -0.02, 0.1}, 0.005, 0.05)));
}

TEST(Rest, refuses_what_is_no_rest) {
  const auto fault_of = [](const RestReadings& all) {
    const auto fine = check_rest(all);
    return fine ? std::optional<RestFault>{} : fine.error();
  };
  EXPECT_EQ(fault_of(readings(kLeastReadings - 1, {}, 0.0, 0.0)), RestFault::TooFew);
  EXPECT_EQ(fault_of(readings(200, {}, 0.03, 0.0)), RestFault::Moving);
  EXPECT_EQ(fault_of(readings(200, {}, 0.0, 0.4)), RestFault::Moving);
  EXPECT_EQ(fault_of(readings(200, {0.0, 0.0, -0.4}, 0.0, 0.0)), RestFault::Turning);
  EXPECT_EQ(fault_of(readings(200, {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}, 0.0, 0.0)), RestFault::Moving);
}

TEST(Rest, the_side_that_is_up_reads_gravity) {
  EXPECT_EQ(side_up({0.3, -0.2, 9.7}).name, "+z");
  EXPECT_EQ(side_up({0.3, -9.9, 0.2}).name, "-y");
  EXPECT_EQ(side_up({-9.5, 1.0, 1.0}).name, "-x");
  std::vector<bool> seen(6);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      Vector3 up{};
      up[axis] = sign * 9.8;
      const std::size_t index = side_up(up).index;
      ASSERT_LT(index, seen.size());
      EXPECT_FALSE(seen[index]);
      seen[index] = true;
    }
  }
}

}  // namespace
}  // namespace nacelle::calibration
