// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/filter.hpp"

#include <gtest/gtest.h>

#include "ekf/model/covariance_parameter.hpp"
#include "support/allocation_guard.hpp"

namespace nacelle::ekf {
namespace {

WallTime at_ms(int ms) { return WallTime{1000s + ms * 1ms}; }

FilterOptions options() {
  FilterOptions o;
  o.process_noise = ProcessNoise{default_process_noise()};
  o.initial.covariance = default_initial_covariance();
  o.sensor_timeout = 20ms;
  o.parts = 3;
  o.queue_limit = 8;
  return o;
}

class FilterTest : public ::testing::Test {
 protected:
  void tell(std::uint16_t part, int ms, StateIndex state, double value, double variance = 1e-4,
            double gate = std::numeric_limits<double>::infinity()) {
    tell_at(ms, part, ms, state, value, variance, gate);
  }
  /// A message that comes at another time than its stamp says.
  void tell_at(int now_ms, std::uint16_t part, int ms, StateIndex state, double value, double variance = 1e-4,
               double gate = std::numeric_limits<double>::infinity()) {
    filter_.offer(part, at_ms(ms), at_ms(now_ms), [&](Reading& r) -> Prepared {
      r.rows = 0;
      r.gate = gate;
      r.add(state, value, variance);
      return {};
    });
  }
  void expect_counts_add_up() {
    for (std::size_t part = 0; part < 3; ++part) {
      const PartStats& s = filter_.stats(part);
      std::uint64_t sum = s.fused + s.waiting;
      for (const std::uint64_t n : s.rejected) sum += n;
      EXPECT_EQ(s.received, sum) << "part " << part;
    }
  }
  Filter filter_{options()};
};

TEST_F(FilterTest, says_nothing_before_the_first_measurement) {
  filter_.step(at_ms(0));
  EXPECT_FALSE(filter_.output(at_ms(0)).has_value());
}

TEST_F(FilterTest, believes_the_first_measurement_in_what_it_measures) {
  tell(0, 0, kVx, 0.5, 0.04);
  filter_.step(at_ms(1));
  EXPECT_DOUBLE_EQ(filter_.belief().mean[kVx], 0.5);
  EXPECT_DOUBLE_EQ(filter_.belief().covariance(kVx, kVx), 0.04);
  EXPECT_DOUBLE_EQ(filter_.belief().covariance(kX, kX), 1e-9);
  EXPECT_EQ(filter_.stamp(), at_ms(0));
}

TEST_F(FilterTest, fuses_in_the_order_of_stamps_whatever_the_order_of_arrival) {
  Filter other{options()};
  const auto tell_other = [&](std::uint16_t part, int ms, StateIndex state, double value) {
    other.offer(part, at_ms(ms), at_ms(ms), [&](Reading& r) -> Prepared {
      r.rows = 0;
      r.add(state, value, 1e-4);
      return {};
    });
  };
  tell(0, 0, kVx, 0.1);
  tell(1, 5, kVyaw, 0.2);
  tell(0, 10, kVx, 0.3);
  tell_other(1, 5, kVyaw, 0.2);
  tell_other(0, 0, kVx, 0.1);
  tell_other(0, 10, kVx, 0.3);
  filter_.step(at_ms(20));
  other.step(at_ms(20));
  EXPECT_EQ(filter_.belief().mean, other.belief().mean) << "bit by bit";
  EXPECT_EQ(filter_.belief().covariance.matrix(), other.belief().covariance.matrix());
}

TEST_F(FilterTest, drives_a_straight_line) {
  for (int i = 0; i <= 100; ++i) {
    tell(0, 20 * i, kVx, 0.5);
    filter_.step(at_ms(20 * i + 1));
  }
  EXPECT_NEAR(filter_.belief().mean[kX], 1.0, 0.02);
  EXPECT_EQ(filter_.stats(0).fused, 101U);
  expect_counts_add_up();
}

TEST_F(FilterTest, refuses_an_older_message_of_the_same_part_and_counts_it) {
  tell(0, 100, kVx, 0.5);
  tell(0, 90, kVx, 0.5);
  tell(0, 100, kVx, 0.5);  // the same stamp again is not older
  filter_.step(at_ms(200));
  EXPECT_EQ(filter_.stats(0).of(Rejection::Stale), 1U);
  EXPECT_EQ(filter_.stats(0).fused, 2U);
  expect_counts_add_up();
}

TEST_F(FilterTest, a_late_message_of_another_part_corrects_without_going_back) {
  tell(0, 100, kVx, 0.5);
  filter_.step(at_ms(101));
  tell(1, 60, kVyaw, 0.3);
  filter_.step(at_ms(102));
  EXPECT_EQ(filter_.stats(1).late, 1U);
  EXPECT_EQ(filter_.stamp(), at_ms(100));
  EXPECT_GT(filter_.belief().covariance(kX, kX), 0.0);
}

TEST_F(FilterTest, a_message_from_the_future_waits_for_its_time) {
  tell(0, 0, kVx, 0.5);
  tell_at(0, 1, 300, kVyaw, 0.3);
  filter_.step(at_ms(100));
  EXPECT_EQ(filter_.stats(1).waiting, 1U);
  expect_counts_add_up();
  filter_.step(at_ms(300));
  EXPECT_EQ(filter_.stats(1).fused, 1U);
  expect_counts_add_up();
}

TEST_F(FilterTest, a_clock_that_runs_ahead_cannot_keep_the_others_out) {
  for (int i = 0; i < 20; ++i) tell_at(0, 1, 200 + i, kVyaw, 0.3);
  EXPECT_EQ(filter_.stats(1).waiting, 8U);
  EXPECT_EQ(filter_.stats(1).of(Rejection::QueueFull), 12U);
  tell(0, 0, kVx, 0.5);
  filter_.step(at_ms(1));
  EXPECT_EQ(filter_.stats(0).fused, 1U);
  expect_counts_add_up();
}

TEST_F(FilterTest, a_stamp_that_the_rates_do_not_explain_is_refused_and_keeps_no_other_out) {
  for (int i = 0; i <= 50; ++i) {
    tell(0, 20 * i, kVx, 1.0);
    filter_.step(at_ms(20 * i), MonotonicTime{1s + 20ms * i});
  }
  tell_at(1010, 0, 6010, kVx, 1.0);  // one stamp 5 s ahead
  for (int i = 51; i <= 300; ++i) {
    tell(0, 20 * i, kVx, 0.0);  // and the robot stands
    filter_.step(at_ms(20 * i), MonotonicTime{1s + 20ms * i});
  }
  EXPECT_EQ(filter_.stats(0).of(Rejection::Future), 1U);
  EXPECT_EQ(filter_.stats(0).of(Rejection::Stale), 0U);
  EXPECT_NEAR(filter_.belief().mean[kX], 1.0, 0.05);
  expect_counts_add_up();
}

TEST_F(FilterTest, a_clock_that_is_set_five_seconds_ahead_does_not_move_the_robot_five_seconds_on) {
  for (const bool timed : {true, false}) {
    Filter filter{options()};
    int ahead_ms = 0;
    for (int i = 0; i <= 100; ++i) {
      if (i == 50) ahead_ms = 5000;
      const WallTime now = at_ms(20 * i + ahead_ms);
      filter.offer(0, now, now, [](Reading& r) -> Prepared {
        r.rows = 0;
        r.add(kVx, 1.0, 1e-4);
        return {};
      });
      filter.step(now, timed ? MonotonicTime{1s + 20ms * i} : MonotonicTime{});
    }
    EXPECT_NEAR(filter.belief().mean[kX], 2.0, 0.05) << timed;
    EXPECT_EQ(filter.clock_steps(), 1U) << timed;
  }
}

TEST_F(FilterTest, a_step_that_comes_a_second_late_carries_the_robot_on_for_that_second) {
  for (int i = 0; i <= 50; ++i) {
    tell(0, 20 * i, kVx, 1.0);
    filter_.step(at_ms(20 * i), MonotonicTime{1s + 20ms * i});
  }
  tell(0, 2000, kVx, 1.0);
  filter_.step(at_ms(2000), MonotonicTime{3s});
  EXPECT_NEAR(filter_.belief().mean[kX], 2.0, 0.05);
  EXPECT_EQ(filter_.clock_steps(), 0U);
}

TEST_F(FilterTest, a_pause_without_measurements_does_not_extrapolate_the_motion) {
  for (const bool told : {true, false}) {
    Filter filter{options()};
    const Duration pause = told ? 5s : 60s;
    for (int i = 0; i <= 100; ++i) {
      const Duration later = i < 50 ? 0s : pause;
      if (i == 50 && told) filter.resume();
      const WallTime now = at_ms(20 * i) + later;
      filter.offer(0, now, now, [](Reading& r) -> Prepared {
        r.rows = 0;
        r.add(kVx, 1.0, 1e-4);
        return {};
      });
      filter.step(now, MonotonicTime{1s + 20ms * i + later});
    }
    EXPECT_NEAR(filter.belief().mean[kX], 2.0, 0.1) << told;
  }
}

TEST_F(FilterTest, stamps_that_stand_still_do_not_put_the_pose_seconds_ahead_and_are_counted) {
  for (int i = 0; i <= 500; ++i) {
    tell_at(20 * i, 0, 0, kVx, 0.5);
    filter_.step(at_ms(20 * i), MonotonicTime{1s + 20ms * i});
    const auto out = filter_.output(at_ms(20 * i));
    if (!out) continue;
    EXPECT_LT(out->belief->mean[kX], 0.5 * 0.4) << i;  // 10 steps of 33 ms
  }
  EXPECT_EQ(filter_.stats(0).same_stamp, 500U);
  EXPECT_EQ(filter_.stats(0).behind, 10s);
}

TEST_F(FilterTest, a_stamp_of_zero_is_refused_and_counted) {
  filter_.offer(0, WallTime{}, at_ms(0), [](Reading&) -> Prepared { return {}; });
  filter_.step(at_ms(1));
  EXPECT_EQ(filter_.stats(0).of(Rejection::NoStamp), 1U);
  EXPECT_FALSE(filter_.initialised());
  expect_counts_add_up();
}

TEST(FilterQueue, grows_with_the_rates_and_loses_nothing) {
  FilterOptions o = options();
  o.queue_limit = 4096;
  Filter filter{o};
  // An IMU of 1 kHz with three parts and odometry of 100 Hz, at 30 Hz output.
  std::uint64_t offered = 0;
  const auto run = [&](int from_ms, int to_ms) {
    for (int ms = from_ms; ms < to_ms; ++ms) {
      for (std::uint16_t part = 0; part < 3; ++part) {
        if (part == 0 && ms % 10 != 0) continue;
        for (int copy = 0; copy < (part == 0 ? 1 : 2); ++copy) {
          ++offered;
          filter.offer(part, at_ms(ms), at_ms(ms), [&](Reading& r) -> Prepared {
            r.rows = 0;
            r.add(part == 0 ? kVx : kVyaw, 0.1, 1e-2);
            return {};
          });
        }
      }
      if (ms % 33 == 0) filter.step(at_ms(ms));
    }
  };
  run(0, 200);
  {
    const test::AllocationGuard guard;
    run(200, 2000);
    EXPECT_EQ(guard.count(), 0U);
  }
  filter.step(at_ms(2000));
  std::uint64_t fused = 0;
  for (std::size_t part = 0; part < 3; ++part) fused += filter.stats(part).fused;
  EXPECT_EQ(fused, offered);
  EXPECT_GE(filter.queue_places(), 2U * 33U * 4U) << "twice the number of waiting readings";
  EXPECT_LE(filter.queue_places(), 512U);
}

TEST(FilterQueue, a_pause_of_half_a_second_allocates_nothing) {
  FilterOptions o = options();
  o.queue_limit = 4096;
  Filter filter{o};
  const auto offer = [&](int from_ms, int to_ms) {
    for (int ms = from_ms; ms < to_ms; ms += 10) {  // an IMU of 100 Hz, odometry of 50 Hz
      for (std::uint16_t part = 0; part < std::uint16_t{2} && (part == 0 || ms % 20 == 0); ++part) {
        filter.offer(part, at_ms(ms), at_ms(ms), [&](Reading& r) -> Prepared {
          r.rows = 0;
          r.add(part == 0 ? kVyaw : kVx, 0.1, 1e-2);
          return {};
        });
      }
    }
  };
  for (int ms = 0; ms < 1000; ms += 20) {
    offer(ms, ms + 20);
    filter.step(at_ms(ms + 20));
  }
  const test::AllocationGuard guard;
  offer(1000, 1500);
  filter.step(at_ms(1500));
  offer(1500, 1520);
  filter.step(at_ms(1520));
  EXPECT_EQ(guard.count(), 0U);
}

TEST(FilterQueue, at_its_limit_fuses_what_is_due_instead_of_losing_it) {
  const auto drive = [](std::size_t limit) {
    FilterOptions o = options();
    o.queue_limit = limit;
    Filter filter{o};
    for (int ms = 0; ms < 300; ++ms) {
      filter.offer(0, at_ms(ms), at_ms(ms), [&](Reading& r) -> Prepared {
        r.rows = 0;
        r.add(kVx, 0.001 * ms, 1e-2);
        return {};
      });
      if (ms % 100 == 99) filter.step(at_ms(ms));
    }
    EXPECT_EQ(filter.stats(0).fused, 300U) << limit;
    return filter.belief().mean;
  };
  EXPECT_EQ(drive(16), drive(4096)) << "bit by bit";
}

TEST_F(FilterTest, angular_acceleration_is_a_difference_over_steps_and_not_over_stamps) {
  const auto tell_ns = [&](std::uint16_t part, Duration since, double rate) {
    filter_.offer(part, at_ms(0) + since, at_ms(0) + since, [&](Reading& r) -> Prepared {
      r.rows = 0;
      r.add(kVyaw, rate, 1e-6);
      return {};
    });
  };
  // Two inputs whose stamps are 4 us apart, and whose messages come in different steps.
  for (int i = 1; i <= 50; ++i) {
    tell_ns(0, 40ms * i, 0.10);
    filter_.step(at_ms(40 * i + 1));
    tell_ns(1, 40ms * i + 4us, 0.12);
    filter_.step(at_ms(40 * i + 21));
    EXPECT_LE(std::abs(filter_.turning().alpha_B.z()), 0.12 / 0.02 + 1e-9) << i;
  }
  EXPECT_LE(std::abs(filter_.turning().alpha_B.z()), 0.02 / 0.02 + 1e-9);
}

TEST_F(FilterTest, a_robot_that_stands_stays_as_sure_between_measurements_as_after_one) {
  FilterOptions o = options();
  o.dynamic_process_noise = true;
  Filter filter{o};
  const auto sure = [&](int ms) {
    filter.step(at_ms(ms));
    return filter.output(at_ms(ms))->belief->covariance(kX, kX);
  };
  filter.offer(0, at_ms(0), at_ms(0), [](Reading& r) -> Prepared {
    r.rows = 0;
    r.add(kVx, 0.0, 1e-9);
    return {};
  });
  const double at_once = sure(1);
  EXPECT_NEAR(sure(10), at_once, 1e-6);  // process noise of a moving robot would add 5e-4
}

TEST_F(FilterTest, the_gate_keeps_outliers_out_and_counts_them) {
  for (int i = 0; i < 20; ++i) {
    tell(0, 10 * i, kVx, 0.5);
    filter_.step(at_ms(10 * i + 1));
  }
  tell(0, 200, kVx, 50.0, 1e-4, 5.0);
  filter_.step(at_ms(201));
  EXPECT_EQ(filter_.stats(0).of(Rejection::Gate), 1U);
  EXPECT_EQ(filter_.stats(0).fused, 20U);
  EXPECT_NEAR(filter_.belief().mean[kVx], 0.5, 1e-6);
  expect_counts_add_up();
}

TEST_F(FilterTest, what_cannot_be_prepared_is_counted_by_its_cause) {
  filter_.offer(2, at_ms(0), at_ms(0), [](Reading&) -> Prepared { return err(Rejection::NoTransform); });
  filter_.offer(2, at_ms(1), at_ms(1), [](Reading&) -> Prepared { return err(Rejection::Covariance); });
  EXPECT_EQ(filter_.stats(2).of(Rejection::NoTransform), 1U);
  EXPECT_EQ(filter_.stats(2).of(Rejection::Covariance), 1U);
  expect_counts_add_up();
}

TEST_F(FilterTest, a_set_pose_discards_the_earlier_state) {
  for (int i = 0; i <= 50; ++i) {
    tell(0, 20 * i, kVx, 0.5);
    filter_.step(at_ms(20 * i));
  }
  tell(0, 1005, kVx, 0.5);
  Reading pose;
  pose.add(kX, 7.0, 0.01);
  pose.add(kYaw, 1.0, 0.02);
  ASSERT_TRUE(filter_.set_pose(pose, at_ms(1010)));
  tell(0, 1010, kVx, 0.5);
  filter_.step(at_ms(1011));

  EXPECT_DOUBLE_EQ(filter_.belief().mean[kX], 7.0);
  EXPECT_DOUBLE_EQ(filter_.belief().mean[kVx], 0.0);
  EXPECT_DOUBLE_EQ(filter_.belief().covariance(kYaw, kYaw), 0.02);
  EXPECT_EQ(filter_.stats(0).of(Rejection::BeforeSetPose), 2U);
  expect_counts_add_up();
}

TEST_F(FilterTest, a_set_pose_with_an_invalid_covariance_is_refused) {
  Reading pose;
  pose.add(kX, 7.0, 1.0);
  pose.add(kY, 7.0, 1.0);
  pose.covariance[1] = pose.covariance[kStates] = 5.0;
  EXPECT_EQ(filter_.set_pose(pose, at_ms(0)).error(), Rejection::Covariance);
  EXPECT_FALSE(filter_.initialised());
}

TEST_F(FilterTest, publishes_at_every_tick_with_stamps_that_only_grow) {
  WallTime last{};
  int outputs = 0;
  for (int tick = 1; tick <= 200; ++tick) {
    const int now = 20 * tick;
    if (tick < 50 || tick > 80) tell(0, now - 15 + tick % 7, kVx, 0.5);  // a gap of thirty ticks, and late jitter
    filter_.step(at_ms(now));
    const auto out = filter_.output(at_ms(now));
    ASSERT_TRUE(out.has_value()) << "tick " << tick;
    EXPECT_GT(out->stamp, last) << "tick " << tick;
    EXPECT_LE(out->stamp, at_ms(now));
    last = out->stamp;
    ++outputs;
  }
  EXPECT_EQ(outputs, 200);
}

TEST_F(FilterTest, stands_still_when_the_clock_does) {
  tell(0, 0, kVx, 0.5);
  filter_.step(at_ms(20));
  EXPECT_TRUE(filter_.output(at_ms(20)).has_value());
  EXPECT_FALSE(filter_.output(at_ms(0)).has_value());
}

TEST_F(FilterTest, carries_the_state_on_when_the_sensors_fall_silent) {
  tell(0, 0, kVx, 1.0);
  filter_.step(at_ms(1));
  filter_.step(at_ms(10));
  EXPECT_EQ(filter_.stamp(), at_ms(0)) << "not yet";
  filter_.step(at_ms(121));
  EXPECT_EQ(filter_.stamp(), at_ms(121));
  EXPECT_NEAR(filter_.belief().mean[kX], 0.121, 1e-9);
}

TEST_F(FilterTest, a_clock_that_is_set_back_does_not_silence_it) {
  for (int i = 0; i <= 50; ++i) {
    tell(0, 20 * i, kVx, 0.5);
    filter_.step(at_ms(20 * i));
    ASSERT_TRUE(filter_.output(at_ms(20 * i)).has_value());
  }
  const double x = filter_.belief().mean[kX];
  tell(0, -60'000, kVx, 0.5);  // came before the next tick: still the old time line
  for (int i = 1; i <= 5; ++i) {
    filter_.step(at_ms(-60'000 + 20 * i));
    const auto out = filter_.output(at_ms(-60'000 + 20 * i));
    ASSERT_TRUE(out.has_value()) << i;
    EXPECT_LE(out->stamp, at_ms(-60'000 + 20 * i));
    tell(0, -60'000 + 20 * i, kVx, 0.5);
  }
  EXPECT_EQ(filter_.clock_steps(), 1U);
  EXPECT_NEAR(filter_.belief().mean[kX], x + 0.5 * 0.1, 0.03);
  EXPECT_GE(filter_.stats(0).fused, 54U);
  expect_counts_add_up();
}

TEST_F(FilterTest, a_clock_that_is_set_ahead_does_not_carry_the_robot_away) {
  tell(0, 0, kVx, 0.5);
  filter_.step(at_ms(1));
  tell(0, 3'600'000, kVx, 0.5);
  filter_.step(at_ms(3'600'001));
  EXPECT_LT(std::abs(filter_.belief().mean[kX]), 0.1);
  EXPECT_EQ(filter_.stamp(), at_ms(3'600'000));
  EXPECT_EQ(filter_.clock_steps(), 1U);
}

TEST(FilterOptions, predict_to_current_time_stamps_the_output_with_now) {
  FilterOptions o = options();
  o.predict_to_current_time = true;
  Filter filter{o};
  filter.offer(0, at_ms(0), at_ms(0), [](Reading& r) -> Prepared {
    r.rows = 0;
    r.add(kVx, 1.0, 0.1);
    return {};
  });
  filter.step(at_ms(10));
  EXPECT_EQ(filter.output(at_ms(10))->stamp, at_ms(10));
}

TEST(FilterAllocations, a_running_filter_allocates_nothing) {
  Filter filter{options()};
  const auto run = [&](int from, int to) {
    for (int i = from; i < to; ++i) {
      for (std::uint16_t part = 0; part < 3; ++part) {
        filter.offer(part, at_ms(20 * i), at_ms(20 * i), [&](Reading& r) -> Prepared {
          return prepare_twist(Vector6d::Constant(0.1), Matrix6d::Identity() * 0.01, {}, filter.turning().w_B,
                               {.mask = kTwistMask, .two_d = true}, r);
        });
      }
      filter.offer(0, at_ms(0), at_ms(20 * i), [](Reading&) -> Prepared { return {}; });
      filter.step(at_ms(20 * i + 1));
      ASSERT_TRUE(filter.output(at_ms(20 * i + 1)).has_value());
    }
  };
  run(1, 10);
  const test::AllocationGuard guard;
  run(10, 200);
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(filter.stats(0).fused, 199U);
}

}  // namespace
}  // namespace nacelle::ekf
