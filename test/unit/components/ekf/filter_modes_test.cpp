// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "ekf/model/covariance_parameter.hpp"
#include "ekf/model/filter.hpp"
#include "ekf_cases.hpp"

namespace nacelle::ekf {
namespace {

WallTime after_ms(int ms) { return WallTime{2000s + ms * 1ms}; }

FilterOptions modest_options() {
  FilterOptions o;
  o.process_noise = ProcessNoise{default_process_noise()};
  o.initial.covariance = default_initial_covariance();
  o.sensor_timeout = 50ms;
  o.period = 20ms;
  o.parts = 2;
  return o;
}

void offer(Filter& filter, std::uint16_t part, int stamp_ms, int now_ms, StateIndex state, double value) {
  filter.offer(part, after_ms(stamp_ms), after_ms(now_ms), [&](Reading& r) -> Prepared {
    r.rows = 0;
    r.add(state, value, 1e-4);
    return {};
  });
}

TEST(FilterHold, keeps_the_estimate_with_the_time_of_now_and_drops_what_waits) {
  Filter filter{modest_options()};
  offer(filter, 0, 0, 0, kVx, 1.0);
  filter.step(after_ms(0));
  offer(filter, 0, 20, 20, kVx, 1.0);
  filter.step(after_ms(20));
  const StateVector mean = filter.belief().mean;
  const StateMatrix covariance = filter.belief().covariance.matrix();
  offer(filter, 0, 30, 30, kVx, 5.0);
  for (int ms = 40; ms < 2000; ms += 20) {
    filter.hold(after_ms(ms));
    const auto out = filter.output(after_ms(ms));
    ASSERT_TRUE(out.has_value());
    EXPECT_EQ(out->stamp, after_ms(ms));
  }
  EXPECT_EQ(filter.belief().mean, mean);
  EXPECT_EQ(filter.belief().covariance.matrix(), covariance);
  EXPECT_EQ(filter.stats(0).waiting, 0U);
  EXPECT_EQ(filter.stats(0).received, 3U);
  EXPECT_EQ(filter.stats(0).fused, 2U);
  offer(filter, 0, 2000, 2000, kVx, 1.0);
  filter.step(after_ms(2000));
  EXPECT_NEAR(filter.belief().mean[kX], mean[kX] + 0.02, 1e-3) << "carried on from the last hold, not from before";
}

TEST(FilterHold, before_the_first_measurement_leaves_nothing_to_publish) {
  Filter filter{modest_options()};
  offer(filter, 0, 0, 0, kVx, 1.0);
  filter.hold(after_ms(0));
  EXPECT_FALSE(filter.initialised());
  EXPECT_FALSE(filter.output(after_ms(0)).has_value());
}

TEST(FilterTimeout, counts_from_the_last_fusion_or_from_the_stamp_as_asked) {
  for (const bool from_stamp : {false, true}) {
    FilterOptions options = modest_options();
    options.timeout_from_stamp = from_stamp;
    Filter filter{options};
    offer(filter, 0, 0, 40, kVx, 1.0);  // 40 ms late
    filter.step(after_ms(40));
    filter.step(after_ms(60));
    EXPECT_EQ(filter.stamp(), from_stamp ? after_ms(60) : after_ms(0)) << "20 ms after it came, 60 ms after its stamp";
    filter.step(after_ms(120));
    EXPECT_EQ(filter.stamp(), after_ms(120)) << from_stamp;
  }
}

TEST(FilterTimeout, from_the_stamp_what_waits_for_its_time_is_no_silence) {
  for (const bool from_stamp : {false, true}) {
    FilterOptions options = modest_options();
    options.timeout_from_stamp = from_stamp;
    Filter filter{options};
    offer(filter, 0, 0, 0, kVx, 1.0);
    filter.step(after_ms(0));
    offer(filter, 0, 150, 20, kVx, 1.0);
    filter.step(after_ms(100));
    EXPECT_EQ(filter.stamp(), from_stamp ? after_ms(0) : after_ms(100));
  }
}

TEST(FilterStart, an_initial_covariance_with_correlations_does_not_keep_the_filter_from_beginning) {
  const unsigned seed = 4602;
  std::mt19937 random{seed};
  for (int i = 0; i < 20; ++i) {
    FilterOptions options = modest_options();
    options.initial.covariance = random_covariance(random);
    Filter filter{options};
    filter.offer(0, after_ms(0), after_ms(0), [&](Reading& r) -> Prepared {
      r.rows = 0;
      for (const StateIndex state : {kX, kY, kYaw, kVx}) r.add(state, 0.5, 1e-6);
      return {};
    });
    filter.step(after_ms(0));
    ASSERT_TRUE(filter.initialised()) << "seed " << seed << " case " << i;
    EXPECT_TRUE(is_positive_definite(filter.belief().covariance)) << "seed " << seed << " case " << i;
    EXPECT_EQ(filter.belief().covariance(kYaw, kYaw), 1e-6);
    EXPECT_EQ(filter.belief().covariance(kVy, kVz), options.initial.covariance(kVy, kVz)) << "not measured, and kept";
  }
}

TEST(AdvanceCommanded, moves_the_mean_of_the_command_and_the_covariance_as_without_it) {
  const unsigned seed = 4603;
  std::mt19937 random{seed};
  for (int i = 0; i < 20; ++i) {
    Belief with;
    with.mean = random_state(random);
    with.covariance = random_covariance(random);
    Belief without = with;
    StateVector commanded = with.mean;
    commanded[kAx] += 1.0;
    commanded[kVyaw] -= 0.3;
    const ProcessNoise noise{default_process_noise()};
    advance(with, commanded, 0.05, noise);
    advance(without, 0.05, noise);
    EXPECT_EQ(with.covariance.matrix(), without.covariance.matrix()) << "seed " << seed << " case " << i;
    EXPECT_EQ(with.mean, propagate(commanded, 0.05)) << "seed " << seed << " case " << i;
  }
}

TEST(FilterObserver, sees_predictions_and_corrections_in_their_order) {
  class Notes final : public FilterObserver {
   public:
    void predicted(WallTime to, double dt_s, const Belief&) override {
      all.push_back("to " + std::to_string((to - after_ms(0)).count() / 1'000'000) + " by " + std::to_string(dt_s));
    }
    void corrected(const Measurement& m, const Result<Fused, UpdateFault>& fused, const Belief& belief) override {
      all.push_back(std::to_string(m.part) + (fused ? " fused" : " not fused"));
      last_vx = belief.mean[kVx];
    }
    std::vector<std::string> all;
    double last_vx{};
  };
  Notes notes;
  Filter filter{modest_options()};
  filter.observe(&notes);
  offer(filter, 0, 0, 0, kVx, 1.0);
  filter.step(after_ms(0));
  offer(filter, 1, 20, 20, kVyaw, 0.1);
  filter.offer(0, after_ms(20), after_ms(20), [&](Reading& r) -> Prepared {
    r.rows = 0;
    r.gate = 1.0;
    r.add(kVx, 9.0, 1e-4);
    return {};
  });
  filter.step(after_ms(20));
  EXPECT_EQ(notes.all, (std::vector<std::string>{"to 20 by 0.020000", "1 fused", "0 not fused"}));
  EXPECT_EQ(notes.last_vx, filter.belief().mean[kVx]);
}

}  // namespace
}  // namespace nacelle::ekf
