// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/control.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "ekf/model/covariance_parameter.hpp"
#include "ekf/model/filter.hpp"

namespace nacelle::ekf {
namespace {

WallTime after(Duration since) { return WallTime{2000s + since}; }

// As in robot_localization's params/ekf.yaml.
ControlOptions stock() {
  ControlOptions o;
  o.controlled = {true, false, false, false, false, true};
  o.timeout = 200ms;
  o.acceleration_limits = {1.3, 0, 0, 0, 0, 3.4};
  o.deceleration_limits = {1.3, 0, 0, 0, 0, 4.5};
  o.acceleration_gains = {0.8, 0, 0, 0, 0, 0.9};
  o.deceleration_gains = {1.0, 0, 0, 0, 0, 1.0};
  return o;
}

TEST(Control, speeds_up_by_the_gain_and_never_beyond_the_limit) {
  EXPECT_DOUBLE_EQ(control_acceleration(0.0, 0.5, stock(), 0), 0.8 * 0.5);
  EXPECT_DOUBLE_EQ(control_acceleration(0.0, 9.0, stock(), 0), 1.3);
  EXPECT_DOUBLE_EQ(control_acceleration(0.0, -9.0, stock(), 0), -1.3);
}

TEST(Control, brakes_with_the_gain_and_limit_of_deceleration) {
  EXPECT_DOUBLE_EQ(control_acceleration(1.0, 0.5, stock(), 5), -0.5);
  EXPECT_DOUBLE_EQ(control_acceleration(9.0, 0.0, stock(), 5), -4.5);
  // The other direction is a brake first: gain 1.0, not 0.9.
  EXPECT_DOUBLE_EQ(control_acceleration(0.5, -0.5, stock(), 5), -1.0);
}

TEST(Control, leaves_axes_alone_that_are_not_commanded) {
  StateVector x = StateVector::Zero();
  x[kAy] = 0.7;
  apply_control(x, {0.5, 9.0, 9.0, 9.0, 9.0, 1.0}, 0.1, stock());
  EXPECT_DOUBLE_EQ(x[kAx], 0.4);
  EXPECT_DOUBLE_EQ(x[kAy], 0.7);
  EXPECT_DOUBLE_EQ(x[kVyaw], 0.9 * 0.1);
  EXPECT_DOUBLE_EQ(x[kVroll], 0.0);
}

class ControlledFilter : public ::testing::Test {
 protected:
  ControlledFilter() {
    FilterOptions o;
    o.process_noise = ProcessNoise{default_process_noise()};
    o.initial.covariance = default_initial_covariance();
    o.sensor_timeout = o.period = 20ms;
    o.parts = 1;
    o.control = stock();
    filter_.emplace(o);
    filter_->offer(0, after(0ms), after(0ms), [](Reading& r) -> Prepared {
      r.rows = 0;
      r.add(kVx, 0.0, 1e-4);
      return {};
    });
    filter_->step(after(1ms));
  }
  std::optional<Filter> filter_;
};

TEST_F(ControlledFilter, predicts_with_the_last_command_while_no_sensor_speaks) {
  for (int i = 1; i <= 50; ++i) {
    filter_->command({1.0, 0, 0, 0, 0, 0.5}, after(20ms * i));
    filter_->step(after(20ms * i + 2ms));
  }
  // dv/dt = 0.8 (1 - v) for a second, and the same with 0.9 for the turn.
  EXPECT_NEAR(filter_->belief().mean[kVx], 1.0 - std::exp(-0.8), 0.02);
  EXPECT_NEAR(filter_->belief().mean[kVyaw], 0.5 * (1.0 - std::exp(-0.9)), 0.02);
}

TEST_F(ControlledFilter, a_command_beyond_its_timeout_counts_as_zero) {
  for (int i = 1; i <= 50; ++i) {
    filter_->command({1.0, 0, 0, 0, 0, 0}, after(20ms * i));
    filter_->step(after(20ms * i + 2ms));
  }
  const double moving = filter_->belief().mean[kVx];
  for (int i = 51; i <= 300; ++i) filter_->step(after(20ms * i));
  EXPECT_GT(moving, 0.5);
  EXPECT_NEAR(filter_->belief().mean[kVx], 0.0, 0.02);
}

}  // namespace
}  // namespace nacelle::ekf
