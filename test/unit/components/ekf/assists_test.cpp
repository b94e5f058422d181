// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/assists.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ekf/model/covariance_parameter.hpp"
#include "ekf/model/filter.hpp"
#include "ekf_cases.hpp"
#include "support/allocation_guard.hpp"

namespace nacelle::ekf {
namespace {

AssistOptions all_on(bool two_d) {
  AssistOptions options;
  options.gyro_bias.on = options.standstill.on = options.slip.on = true;
  options.gyro_bias.yaw_only = options.standstill.two_d = two_d;
  return options;
}

// Wheels and IMU of a robot that drives, slips, stands and is lifted, chosen anew each second, with little noise.
class Messages {
 public:
  Messages(unsigned seed, double variance, bool two_d) : random_(seed), variance_(variance), two_d_(two_d) {}

  void next(int n, Measurement& out) {
    if (n % 100 == 0) mode_ = std::uniform_int_distribution<int>{0, 4}(random_);
    out.stamp = WallTime{1000s + n * 10ms};
    Reading& r = out.reading;
    r = {};
    const bool stands = mode_ == 0 || mode_ == 1;
    const double speed = stands ? 0.0 : 0.4 + 0.1 * any(), rate = stands ? 0.0 : 0.5 * any();
    const double slip = mode_ == 3 ? 1.0 : 0.0, lift = mode_ == 1 ? 0.5 : 0.0;
    if (n % 2 == 0) {
      out.part = 0;
      const double rates[3]{0.01 + 0.001 * any(), -0.01 + 0.001 * any(), 0.02 + rate + lift + 0.001 * any()};
      if (!two_d_) {
        r.add(kVroll, rates[0], variance_);
        r.add(kVpitch, rates[1], variance_);
      }
      r.add(kVyaw, rates[2], variance_);
      r.witness = {.source = Witness::Source::Imu,
                   .linear = {0.1 * any() + 3.0 * lift, 0.0, 9.8},
                   .angular = {rates[0], rates[1], rates[2]}};
    } else {
      out.part = 1;
      r.add(kVx, speed + slip, variance_);
      r.add(kVy, 0.0, variance_);
      r.add(kVyaw, rate + slip, 10.0 * variance_);
      if (n % 10 == 1) r.add(kYaw, any(), 0.1);
      r.witness = {.source = Witness::Source::Wheels,
                   .teaches_bias = n % 4 == 1,
                   .linear = {speed + slip, 0.0, 0.0},
                   .angular = {0.0, 0.0, rate + slip}};
    }
    for (const StateIndex i : {kZ, kRoll, kPitch, kVz}) r.add(i, 0.0, 1e-6);
    if (two_d_) {
      for (const StateIndex i : {kVroll, kVpitch, kAz}) r.add(i, 0.0, 1e-6);
    }
  }

 private:
  double any() { return std::uniform_real_distribution<double>{-0.5, 0.5}(random_); }
  std::mt19937 random_;
  double variance_;
  bool two_d_;
  int mode_{0};
};

struct LongCase {
  double variance;
  bool two_d;
  int steps;
};
class AssistedLongRun : public ::testing::TestWithParam<LongCase> {};

TEST_P(AssistedLongRun, the_joint_covariance_stays_symmetric_and_positive_definite_with_every_switch_on) {
  const auto [variance, two_d, steps] = GetParam();
  const unsigned seed = 48;
  const AssistOptions options = all_on(two_d);
  const ProcessNoise noise{default_process_noise()};
  Messages messages{seed, variance, two_d};
  Belief belief;
  for (int i = 0; i < kStates; ++i) belief.covariance(i, i) = 1e-9;
  AssistState state = unassisted(options);
  Measurement measurement;
  for (int n = 0; n < steps; ++n) {
    messages.next(n, measurement);
    advance(state, belief.mean, 0.01, options);
    advance(belief, 0.01, noise);
    ASSERT_TRUE(fuse(belief, state, measurement.stamp, measurement.reading, options))
        << "seed " << seed << ", step " << n;
    if (n % 5000 != 0) continue;
    ASSERT_TRUE(is_positive_definite(belief.covariance, state.gyro_bias)) << "seed " << seed << ", step " << n;
    ASSERT_EQ(belief.covariance.matrix(), belief.covariance.matrix().transpose()) << "step " << n;
    ASSERT_EQ(state.gyro_bias.covariance, state.gyro_bias.covariance.transpose()) << "step " << n;
  }
  EXPECT_TRUE(is_positive_definite(belief.covariance, state.gyro_bias));
  EXPECT_TRUE(belief.mean.allFinite());
  EXPECT_GT(state.standstill.updates, 0U);
  EXPECT_GT(state.standstill.contradictions, 0U);
  EXPECT_GT(state.slip.inflated, 0U);
}
#ifdef NACELLE_SANITIZED
constexpr int kLongest = 100'000;
#else
constexpr int kLongest = 1'000'000;
#endif
INSTANTIATE_TEST_SUITE_P(Variances, AssistedLongRun,
                         ::testing::Values(LongCase{1e-9, true, kLongest}, LongCase{1e-9, false, kLongest / 10},
                                           LongCase{1e-3, false, kLongest / 10}));

TEST(Assists, a_copy_of_belief_and_state_replays_to_the_same_bits) {
  const AssistOptions options = all_on(true);
  const ProcessNoise noise{default_process_noise()};
  Messages messages{7, 1e-5, true};
  Belief belief;
  for (int i = 0; i < kStates; ++i) belief.covariance(i, i) = 1e-3;
  AssistState state = unassisted(options);
  std::vector<Measurement> seen(2000);
  for (int n = 0; n < 2000; ++n) messages.next(n, seen[static_cast<std::size_t>(n)]);
  Belief saved_belief;
  AssistState saved;
  const auto replay = [&](std::size_t from, Belief& b, AssistState& s) {
    for (std::size_t n = from; n < seen.size(); ++n) {
      if (n == 1000 && from == 0) {
        saved_belief = b;
        saved = s;
      }
      advance(s, b.mean, 0.01, options);
      advance(b, 0.01, noise);
      ASSERT_TRUE(fuse(b, s, seen[n].stamp, seen[n].reading, options));
    }
  };
  replay(0, belief, state);
  replay(1000, saved_belief, saved);
  EXPECT_EQ(belief.mean, saved_belief.mean);
  EXPECT_EQ(belief.covariance.matrix(), saved_belief.covariance.matrix());
  EXPECT_EQ(state.gyro_bias.mean_rps, saved.gyro_bias.mean_rps);
  EXPECT_EQ(state.gyro_bias.cross, saved.gyro_bias.cross);
  EXPECT_EQ(state.standstill.updates, saved.standstill.updates);
  EXPECT_EQ(state.slip.inflated, saved.slip.inflated);
}

TEST(Assists, a_filter_with_every_switch_on_takes_nothing_from_the_heap) {
  FilterOptions options;
  options.process_noise = ProcessNoise{default_process_noise()};
  options.initial.covariance = default_initial_covariance();
  options.parts = 2;
  options.two_d_mode = true;
  options.assists = all_on(true);
  Filter filter{options};
  Messages messages{3, 1e-5, true};
  Measurement measurement;
  const auto run = [&](int from, int to) {
    for (int n = from; n < to; ++n) {
      messages.next(n, measurement);
      filter.offer(measurement.part, measurement.stamp, measurement.stamp, [&](Reading& r) -> Prepared {
        r = measurement.reading;
        return {};
      });
      filter.step(measurement.stamp);
    }
  };
  run(1, 500);
  const test::AllocationGuard guard;
  run(500, 3000);
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(filter.assists().standstill.updates, 0U);
}

TEST(Assists, a_pose_that_is_told_and_a_reset_keep_the_covariance_a_covariance) {
  FilterOptions options;
  options.process_noise = ProcessNoise{default_process_noise()};
  options.initial.covariance = default_initial_covariance();
  options.parts = 2;
  options.assists = all_on(true);
  Filter filter{options};
  Messages messages{3, 1e-5, true};
  Measurement measurement;
  for (int n = 0; n < 1000; ++n) {
    messages.next(n, measurement);
    filter.offer(measurement.part, measurement.stamp, measurement.stamp, [&](Reading& r) -> Prepared {
      r = measurement.reading;
      return {};
    });
    filter.step(measurement.stamp);
  }
  const Eigen::Vector3d learnt = filter.assists().gyro_bias.mean_rps;
  EXPECT_GT(learnt.norm(), 0.001);
  Reading pose;
  pose.add(kX, 1.0, 0.01);
  ASSERT_TRUE(filter.set_pose(pose, measurement.stamp));
  EXPECT_TRUE(is_positive_definite(filter.belief().covariance, filter.assists().gyro_bias));
  EXPECT_EQ(filter.assists().gyro_bias.mean_rps, learnt) << "the gyro is the same";
  filter.reset();
  EXPECT_EQ(filter.assists().gyro_bias.mean_rps, Eigen::Vector3d::Zero());
}

// --- standstill ---

class StandstillTest : public ::testing::Test {
 protected:
  /// `seconds` of an IMU at 100 Hz and wheels at 50 Hz.
  void run(double seconds, double yaw_rate, double force_x = 0.0, double wheels = 0.0) {
    for (int i = 0; i < static_cast<int>(seconds * 100.0); ++i) {
      now_ += 10ms;
      state_.see_imu(now_, {.source = Witness::Source::Imu, .linear = {force_x, 0, 9.8}, .angular = {0, 0, yaw_rate}},
                     bias_, bias_stddev_, options_);
      if (i % 2 == 0) state_.see_wheels(now_, {.source = Witness::Source::Wheels, .linear = {wheels, 0, 0}}, options_);
    }
  }
  StandstillOptions options_{.on = true};
  Standstill state_;
  double bias_ = 0.0, bias_stddev_ = -1.0;
  WallTime now_{1000s};
};

TEST_F(StandstillTest, stands_once_the_wheels_have_stood_for_the_time) {
  run(1.0, 0.3, 0.0, 0.4);
  EXPECT_FALSE(state_.standing);
  run(0.4, 0.0);
  EXPECT_FALSE(state_.standing);
  run(1.2, 0.0);
  EXPECT_TRUE(state_.standing);
  run(0.02, 0.0, 0.0, 0.01);
  EXPECT_FALSE(state_.standing) << "the first turn of a wheel ends it";
}

TEST_F(StandstillTest, a_robot_that_is_turned_by_hand_does_not_stand) {
  run(2.0, 0.001);
  ASSERT_TRUE(state_.standing);
  run(2.0, 0.02);
  EXPECT_FALSE(state_.standing);
  EXPECT_EQ(state_.contradictions, 1U);
  run(1.5, 0.001);
  EXPECT_TRUE(state_.standing) << "it reads what it read before";
}

TEST_F(StandstillTest, a_robot_that_is_pushed_does_not_stand) {
  run(2.0, 0.0);
  run(0.3, 0.0, 1.0);
  EXPECT_FALSE(state_.standing);
}

TEST_F(StandstillTest, a_rate_beyond_the_limit_is_motion_unless_it_is_the_bias) {
  run(3.0, 0.08);
  EXPECT_FALSE(state_.standing);
  state_ = {};
  bias_ = 0.079;
  bias_stddev_ = 1e-4;
  run(3.0, 0.08);
  EXPECT_TRUE(state_.standing);
}

TEST_F(StandstillTest, without_an_imu_the_wheels_decide) {
  for (int i = 0; i < 60; ++i)
    state_.see_wheels(now_ += 20ms, {.source = Witness::Source::Wheels, .linear = {0, 0, 0}}, options_);
  EXPECT_TRUE(state_.standing);
}

TEST_F(StandstillTest, a_speed_that_is_no_number_is_no_standstill) {
  run(2.0, 0.0);
  state_.see_wheels(now_ += 10ms, {.source = Witness::Source::Wheels, .linear = {std::nan(""), 0, 0}}, options_);
  EXPECT_FALSE(state_.standing);
}

// --- slip ---

class SlipTest : public ::testing::Test {
 protected:
  Doubt run(double seconds, double acceleration, double gyro, double wheel_acceleration, double wheel_yaw_rate) {
    Doubt last;
    for (int i = 0; i < static_cast<int>(seconds * 100.0); ++i) {
      now_ += 10ms;
      wheels_ += 0.01 * wheel_acceleration;
      state_.see_imu(now_, {.source = Witness::Source::Imu, .has_force = has_force_, .linear = {acceleration, 0, 9.8}},
                     gyro);
      if (i % 2 == 0)
        last = state_.see_wheels(
            now_, {.source = Witness::Source::Wheels, .linear = {wheels_, 0, 0}, .angular = {0, 0, wheel_yaw_rate}},
            options_);
    }
    return last;
  }
  SlipOptions options_{.on = true};
  Slip state_;
  double wheels_ = 0.0;
  bool has_force_ = true;
  WallTime now_{1000s};
};

TEST_F(SlipTest, wheels_that_the_imu_confirms_are_not_doubted) {
  run(2.0, 0.0, 0.0, 0.0, 0.0);
  run(1.0, 1.0, 0.3, 1.0, 0.3);
  run(1.0, -1.0, 0.3, -1.0, 0.3);
  EXPECT_EQ(state_.inflated, 0U);
  EXPECT_TRUE(state_.armed);
}

TEST_F(SlipTest, wheels_that_spin_up_beside_an_accelerometer_that_does_not_are_doubted) {
  run(2.0, 0.0, 0.0, 0.0, 0.0);
  const Doubt doubt = run(0.2, 0.0, 0.0, 4.0, 0.0);
  EXPECT_TRUE(state_.slipping);
  EXPECT_EQ(state_.episodes, 1U);
  EXPECT_NEAR(std::sqrt(doubt.speed_mps2), 10.0 * 0.8, 2.0);
  run(0.2, 0.0, 0.0, -4.0, 0.0);
  run(1.0, 0.0, 0.0, 0.0, 0.0);
  EXPECT_FALSE(state_.slipping);
}

TEST_F(SlipTest, a_yaw_rate_that_the_gyro_does_not_confirm_is_doubted) {
  run(2.0, 0.0, 0.2, 0.0, 0.2);
  const Doubt doubt = run(0.5, 0.0, 0.2, 0.0, 1.0);
  EXPECT_TRUE(state_.slipping);
  EXPECT_NEAR(std::sqrt(doubt.yaw_rate_rps2), 8.0, 1.0);
  EXPECT_NEAR(std::sqrt(doubt.speed_mps2), 8.0 * 0.15, 0.2);
}

TEST_F(SlipTest, a_ramp_is_no_slip) {
  run(2.0, 0.0, 0.0, 0.0, 0.0);
  run(5.0, 9.8 * std::sin(0.087), 0.0, 0.0, 0.0);
  EXPECT_EQ(state_.inflated, 0U);
}

TEST_F(SlipTest, an_imu_that_never_agreed_is_not_believed) {
  run(5.0, 0.0, 0.5, 0.0, 0.0);
  EXPECT_EQ(state_.inflated, 0U);
  EXPECT_TRUE(state_.distrusts_imu);
}

TEST_F(SlipTest, disagreement_that_lasts_is_an_imu_that_is_wrong) {
  run(2.0, 0.0, 0.0, 0.0, 0.0);
  run(5.0, 0.0, 0.0, 0.0, 0.5);
  EXPECT_TRUE(state_.distrusts_imu);
  EXPECT_FALSE(state_.slipping);
  EXPECT_EQ(state_.distrusted, 1U);
  run(20.0, 0.0, 0.5, 0.0, 0.5);
  EXPECT_FALSE(state_.distrusts_imu) << "it has agreed for four times as long";
  EXPECT_TRUE(state_.armed);
}

TEST_F(SlipTest, without_an_accelerometer_the_gyro_alone_judges) {
  has_force_ = false;
  run(2.0, 0.0, 0.0, 0.0, 0.0);
  run(0.2, 0.0, 0.0, 4.0, 0.0);
  EXPECT_EQ(state_.inflated, 0U);
  run(0.5, 0.0, 0.0, 0.0, 1.0);
  EXPECT_GT(state_.inflated, 0U);
}

}  // namespace
}  // namespace nacelle::ekf
