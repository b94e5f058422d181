// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/wheeled_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ekf/model/update.hpp"

namespace nacelle::ekf {
namespace {

const VehicleLimits kLimits{.speed_mps = 0.5, .acceleration_mps2 = 1.5, .yaw_rate_rps = 2.0, .interval_s = 0.02};

TEST(WheeledNoise, is_that_of_an_unknown_acceleration_between_updates) {
  const StateMatrix Q = wheeled_process_noise(kLimits);
  const double s2 = 1.5 * 1.5 / 3.0, tau = 0.02;
  EXPECT_DOUBLE_EQ(Q(kVx, kVx), s2 * tau);
  EXPECT_DOUBLE_EQ(Q(kX, kX), s2 * tau * tau * tau / 4.0);
  EXPECT_DOUBLE_EQ(Q(kY, kY), Q(kX, kX));
  const double turn_s2 = 6.0 * 6.0 / 3.0;  // 2 rad/s in the third of a second in which it reaches its speed
  EXPECT_NEAR(Q(kVyaw, kVyaw), turn_s2 * tau, 1e-12);
  EXPECT_NEAR(Q(kYaw, kYaw), turn_s2 * tau * tau * tau / 4.0, 1e-15);
  EXPECT_LT(Q(kVy, kVy), Q(kVx, kVx));
}

// A vehicle that chooses an acceleration within its limits at random in each interval does to its velocity and position what the
// matrix says.
TEST(WheeledNoise, holds_the_errors_of_simulated_intervals) {
  const unsigned seed = 74;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> any{-1.5, 1.5};
  const StateMatrix Q = wheeled_process_noise(kLimits);
  double velocity = 0.0, position = 0.0;
  constexpr int kIntervals = 20000;
  for (int i = 0; i < kIntervals; ++i) {
    const double a = any(random), tau = kLimits.interval_s;
    velocity += a * tau * a * tau / kIntervals;
    position += 0.25 * a * a * tau * tau * tau * tau / kIntervals;
  }
  EXPECT_NEAR(velocity / (Q(kVx, kVx) * kLimits.interval_s), 1.0, 0.03) << "seed " << seed;
  EXPECT_NEAR(position / (Q(kX, kX) * kLimits.interval_s), 1.0, 0.03) << "seed " << seed;
}

TEST(WheeledNoise, is_a_covariance_for_every_vehicle) {
  for (const double scale : {1e-3, 1.0, 1e3}) {
    for (const bool measured : {false, true}) {
      const VehicleLimits limits{.speed_mps = scale,
                                 .acceleration_mps2 = 2.0 * scale,
                                 .yaw_rate_rps = scale,
                                 .interval_s = 0.01,
                                 .measures_acceleration = measured};
      EXPECT_TRUE(is_positive_definite(wheeled_process_noise(limits))) << scale << measured;
    }
  }
}

TEST(WheeledNoise, lets_an_acceleration_change_only_if_it_is_measured) {
  VehicleLimits limits = kLimits;
  EXPECT_LT(wheeled_process_noise(limits)(kAx, kAx), 1e-9);
  limits.measures_acceleration = true;
  EXPECT_NEAR(wheeled_process_noise(limits)(kAx, kAx), 2.0 * 0.75 / (0.5 / 1.5), 1e-12);
}

TEST(WheeledNoise, takes_a_given_yaw_acceleration) {
  VehicleLimits limits = kLimits;
  limits.yaw_acceleration_rps2 = 3.0;
  EXPECT_NEAR(wheeled_process_noise(limits)(kVyaw, kVyaw), 3.0 * 0.02, 1e-12);
}

}  // namespace
}  // namespace nacelle::ekf
