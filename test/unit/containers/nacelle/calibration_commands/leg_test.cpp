// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/leg.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace nacelle::calibration {
namespace {

constexpr MonotonicTime kStart{10s};
constexpr Duration kPeriod = 20ms;

LegSettings settings() {
  LegSettings all;
  all.target = 2.0;
  all.speed = 0.2;
  all.acceleration = 0.2;
  return all;
}

/// A base that follows its commands, and stops by its timeout until it has been neutral for one.
struct Base {
  double position = 0.0, speed = 0.0;
  bool is_held = false, is_armed = true;
  MonotonicTime commanded_at = kStart, moving_command_at = kStart;

  void command(double wanted, MonotonicTime now) {
    if (now - commanded_at > 500ms) is_armed = false;
    commanded_at = now;
    if (wanted != 0.0 && !is_armed && now - moving_command_at > 500ms) is_armed = true;
    if (wanted != 0.0) moving_command_at = now;
    speed = is_armed && !is_held ? wanted : 0.0;
  }
  void step(Duration dt, MonotonicTime now) {
    if (now - commanded_at > 500ms) speed = 0.0;
    position += speed * to_seconds(dt);
  }
};

/// Runs a leg until it is over, or for two minutes. `before` sees each period before the command.
struct Trip {
  Base base;
  double fastest = 0.0, steepest = 0.0;
  bool hears = true, runs = true;

  LegState go(
      Leg& leg, const std::function<void(Trip&, MonotonicTime)>& before = [](Trip&, MonotonicTime) {}) {
    double last = 0.0;
    for (MonotonicTime now = kStart; now < kStart + 120s && !leg.is_over(); now = now + kPeriod) {
      base.step(kPeriod, now);
      before(*this, now);
      if (!runs) continue;
      if (hears) leg.take(base.position, now);
      const double speed = leg.command(now);
      EXPECT_GE(speed, 0.0);
      fastest = std::max(fastest, speed);
      steepest = std::max(steepest, speed - last);
      last = speed;
      base.command(speed, now);
    }
    EXPECT_EQ(leg.command(kStart + 200s), 0.0);
    return leg.state();
  }
};

TEST(Leg, drives_to_the_target_gently_and_stands) {
  Leg leg{settings(), kStart};
  Trip trip;
  EXPECT_EQ(trip.go(leg), LegState::Done);
  EXPECT_NEAR(trip.base.position, 2.0, 0.02);
  EXPECT_EQ(leg.progress(), trip.base.position);
  EXPECT_EQ(trip.base.speed, 0.0);
  EXPECT_DOUBLE_EQ(trip.fastest, 0.2);
  EXPECT_LE(trip.steepest, 0.25 * 0.2 + 1e-9);
}

TEST(Leg, a_late_command_lets_the_base_be_neutral_and_then_goes_on) {
  Leg leg{settings(), kStart};
  Trip trip;
  int gaps = 0;
  const auto late = [&](Trip& now_is, MonotonicTime now) {
    // Twice a second of silence, as on a machine that is busy.
    const double t = to_seconds(now - kStart);
    now_is.runs = !((t > 3.0 && t < 4.0) || (t > 7.0 && t < 8.0));
    if (!now_is.runs && now_is.base.speed == 0.0) ++gaps;
  };
  EXPECT_EQ(trip.go(leg, late), LegState::Done);
  EXPECT_GT(gaps, 0) << "the base did not stop by its timeout: this test shows nothing";
  EXPECT_NEAR(trip.base.position, 2.0, 0.02);
}

TEST(Leg, a_base_that_stopped_unseen_is_let_be_neutral_as_well) {
  Leg leg{settings(), kStart};
  Trip trip;
  bool once = false;
  const auto disarmed = [&](Trip& now_is, MonotonicTime now) {
    if (!once && now > kStart + 3s) {
      once = true;
      now_is.base.is_armed = false;  // commands were lost on the way
    }
  };
  EXPECT_EQ(trip.go(leg, disarmed), LegState::Done);
  EXPECT_TRUE(once);
}

TEST(Leg, without_readings_the_base_is_stopped_and_goes_on_when_they_return) {
  Leg leg{settings(), kStart};
  Trip trip;
  bool stopped = false;
  const auto silent = [&](Trip& now_is, MonotonicTime now) {
    const double t = to_seconds(now - kStart);
    now_is.hears = !(t > 3.0 && t < 6.0);
    if (t > 3.6 && t < 6.0) {
      EXPECT_EQ(now_is.base.speed, 0.0) << t;
      stopped = true;
    }
  };
  EXPECT_EQ(trip.go(leg, silent), LegState::Done);
  EXPECT_TRUE(stopped);
}

TEST(Leg, is_lost_when_readings_do_not_return) {
  Leg leg{settings(), kStart};
  Trip trip;
  EXPECT_EQ(trip.go(leg, [](Trip& now_is, MonotonicTime now) { now_is.hears = now < kStart + 3s; }), LegState::Lost);
  EXPECT_EQ(trip.base.speed, 0.0);
}

TEST(Leg, gives_up_a_base_that_does_not_follow) {
  Leg leg{settings(), kStart};
  Trip trip;
  trip.base.is_held = true;
  EXPECT_EQ(trip.go(leg), LegState::Stalled);
}

TEST(Leg, stalls_count_only_one_after_another) {
  auto slow = settings();
  slow.most_stalls = 2;
  Leg leg{slow, kStart};
  Trip trip;
  int stalls = 0;
  LegState before = LegState::Driving;
  // Held for three seconds after each 0.3 m: a stall, and motion again.
  MonotonicTime until = kStart;
  double next = 0.3;
  const auto sticky = [&](Trip& now_is, MonotonicTime now) {
    if (now_is.base.position > next) {
      next += 0.3;
      until = now + 3s;
    }
    now_is.base.is_held = now < until;
    if (leg.state() == LegState::Pausing && before == LegState::Driving) ++stalls;
    before = leg.state();
  };
  EXPECT_EQ(trip.go(leg, sticky), LegState::Done);
  EXPECT_GT(stalls, 2);
}

TEST(Leg, gives_up_wheels_that_go_astray) {
  for (const double jump : {-5.0, 5.0}) {
    Leg leg{settings(), kStart};
    Trip trip;
    const auto restarted = [&](Trip& now_is, MonotonicTime now) {
      if (now == kStart + 3s) now_is.base.position += jump;
    };
    EXPECT_EQ(trip.go(leg, restarted), LegState::Astray) << jump;
    EXPECT_EQ(trip.base.speed, 0.0);
  }
}

}  // namespace
}  // namespace nacelle::calibration
