// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/command_input.hpp"

#include <gtest/gtest.h>

#include <random>

namespace nacelle::diff_drive {
namespace {

using State = CommandInput::State;

/// An input with simulated time; every step is one control cycle.
struct Rig {
  explicit Rig(CommandInput::Settings settings)
      : inbox(settings.sources.size(), settings.locks.size()), input(std::move(settings)) {
    input.arm(now);
  }
  void say(std::size_t source, double linear_mps, bool first = false) {
    inbox.sources[source].commands.put({{linear_mps, 0.0}, now, now, first});
  }
  /// The speed wanted one cycle later.
  double cycle(Duration length = 20ms) {
    now += length;
    DriveCommand newest;
    static_cast<void>(input.take(inbox, now, newest));
    return input.wanted(now).linear_mps;
  }
  /// Says the same in every cycle for this long; the speed wanted at the end.
  double say_for(Duration length, std::size_t source, double linear_mps) {
    double wanted = 0;
    for (Duration past{}; past < length; past += 20ms) {
      say(source, linear_mps);
      wanted = cycle();
    }
    return wanted;
  }
  void set_emergency(bool set) { set ? inbox.emergency_stop.set() : inbox.emergency_stop.release(now); }

  MonotonicTime now{100s};
  CommandInbox inbox;
  CommandInput input;
};

CommandInput::Settings one(RearmRule rearm, Duration timeout = 500ms) {
  CommandInput::Settings settings;
  settings.sources = {{timeout, 0}};
  settings.rearm = rearm;
  return settings;
}
CommandInput::Settings navigation_and_operator(RearmRule rearm = RearmRule::Fresh) {
  CommandInput::Settings settings;
  settings.sources = {{500ms, 10}, {300ms, 100}};
  settings.locks = {{0ms, 50}};
  settings.rearm = rearm;
  return settings;
}
constexpr std::size_t kNavigation = 0, kOperator = 1;

TEST(CommandInput, wants_nothing_before_the_first_command) {
  Rig rig{one(RearmRule::Fresh)};
  EXPECT_EQ(rig.cycle(100s), 0.0);
  EXPECT_EQ(rig.input.state(), State::Waiting);
  EXPECT_EQ(rig.input.stats().timeouts, 0U);
}

TEST(CommandInput, gives_a_command_up_after_the_timeout_and_not_before) {
  Rig rig{one(RearmRule::Fresh)};
  rig.say(0, 0.3);
  EXPECT_EQ(rig.cycle(500ms), 0.3);
  EXPECT_EQ(rig.cycle(1ns), 0.0);
  EXPECT_EQ(rig.input.state(), State::TimedOut);
  EXPECT_EQ(rig.input.stats().timeouts, 1U);
}

TEST(CommandInput, never_times_out_with_a_timeout_of_zero) {
  Rig rig{one(RearmRule::Fresh, 0ms)};
  rig.say(0, 0.3);
  rig.cycle();
  EXPECT_EQ(rig.cycle(1h), 0.3);
}

TEST(CommandInput, drops_commands_from_before_it_was_armed) {
  Rig rig{one(RearmRule::Fresh)};
  rig.say(0, 0.3);
  rig.now += 1ns;
  rig.input.arm(rig.now);
  EXPECT_EQ(rig.cycle(), 0.0);
  EXPECT_EQ(rig.input.stats().early, 1U);
}

TEST(CommandInput, fresh_follows_any_command_after_a_stop) {
  Rig rig{one(RearmRule::Fresh)};
  rig.say(0, 0.3);
  rig.cycle();
  rig.set_emergency(true);
  EXPECT_EQ(rig.say_for(100ms, 0, 0.3), 0.0);
  rig.set_emergency(false);
  rig.now += 1ns;
  EXPECT_EQ(rig.cycle(), 0.0) << "a release is no command";
  rig.say(0, 0.2);
  EXPECT_EQ(rig.cycle(), 0.2);
}

TEST(CommandInput, two_holds_end_when_both_have_ended) {
  Rig rig{one(RearmRule::Fresh)};
  rig.inbox.unguarded.set();
  EXPECT_EQ(rig.say_for(100ms, 0, 0.3), 0.0);
  EXPECT_TRUE(rig.input.is_held(Hold::Unguarded));
  rig.set_emergency(true);
  rig.inbox.unguarded.release(rig.now);
  rig.now += 1ns;
  EXPECT_EQ(rig.say_for(100ms, 0, 0.3), 0.0);
  EXPECT_FALSE(rig.input.is_held(Hold::Unguarded));
  rig.set_emergency(false);
  rig.now += 1ns;
  EXPECT_EQ(rig.say_for(100ms, 0, 0.3), 0.3);
}

TEST(CommandInput, neutral_does_not_follow_a_sender_that_never_paused) {
  Rig rig{one(RearmRule::Neutral)};
  rig.now += 1s;
  rig.say(0, 0.3);
  ASSERT_EQ(rig.cycle(), 0.3);
  rig.set_emergency(true);
  EXPECT_EQ(rig.say_for(1s, 0, 0.3), 0.0);
  rig.set_emergency(false);
  EXPECT_EQ(rig.say_for(10s, 0, 0.3), 0.0);
  EXPECT_TRUE(rig.input.waits_for_neutral(rig.now));
}

TEST(CommandInput, neutral_follows_after_a_timeout_of_silence) {
  Rig rig{one(RearmRule::Neutral)};
  rig.now += 1s;
  rig.say_for(1s, 0, 0.3);
  rig.set_emergency(true);
  rig.say_for(100ms, 0, 0.3);
  rig.set_emergency(false);
  rig.cycle(460ms);
  rig.say(0, 0.2);
  EXPECT_EQ(rig.cycle(), 0.0) << "480 ms of silence are not enough";
  rig.cycle(500ms);
  rig.say(0, 0.2);
  EXPECT_EQ(rig.cycle(), 0.2);
  EXPECT_FALSE(rig.input.waits_for_neutral(rig.now));
}

TEST(CommandInput, neutral_follows_after_a_timeout_of_zeros) {
  Rig rig{one(RearmRule::Neutral)};
  rig.now += 1s;
  rig.say_for(1s, 0, 0.3);
  rig.set_emergency(true);
  rig.say_for(600ms, 0, 0.0);
  rig.set_emergency(false);
  rig.say(0, 0.2);
  EXPECT_EQ(rig.cycle(), 0.2) << "a stick that was at rest while the stop was set has been neutral";
}

TEST(CommandInput, neutral_after_a_timeout_needs_no_more_than_a_command) {
  Rig rig{one(RearmRule::Neutral)};
  rig.now += 1s;
  rig.say(0, 0.3);
  rig.cycle();
  ASSERT_EQ(rig.cycle(600ms), 0.0);
  rig.say(0, 0.2);
  EXPECT_EQ(rig.cycle(), 0.2) << "the silence was the timeout itself";
}

TEST(CommandInput, refused_commands_are_neither_zero_nor_silence) {
  Rig rig{one(RearmRule::Neutral)};
  rig.now += 1s;
  rig.say_for(1s, 0, 0.3);
  for (int i = 0; i < 50; ++i) {  // a second of NaN
    rig.inbox.sources[0].refused_at_ns = rig.now.nanoseconds();
    rig.cycle();
  }
  EXPECT_EQ(rig.input.state(), State::TimedOut);
  EXPECT_EQ(rig.say_for(2s, 0, 0.3), 0.0);
  rig.cycle(500ms);
  rig.say(0, 0.3);
  EXPECT_EQ(rig.cycle(), 0.3);
}

TEST(CommandInput, neutral_after_an_activation_follows_a_sender_that_began_after_it) {
  Rig rig{one(RearmRule::Neutral)};
  rig.say(0, 0.0, true);
  rig.cycle();
  rig.say(0, 0.3);
  EXPECT_EQ(rig.cycle(), 0.3);
}

TEST(CommandInput, neutral_after_an_activation_does_not_follow_one_that_was_there_before) {
  Rig rig{one(RearmRule::Neutral)};
  EXPECT_EQ(rig.say_for(5s, 0, 0.3), 0.0);
  rig.cycle(500ms);
  rig.say(0, 0.3);
  EXPECT_EQ(rig.cycle(), 0.3);
}

TEST(CommandInput, the_operator_takes_over_in_one_cycle_and_gives_back_by_silence) {
  Rig rig{navigation_and_operator()};
  EXPECT_EQ(rig.say_for(200ms, kNavigation, 0.4), 0.4);
  rig.say(kNavigation, 0.4);
  rig.say(kOperator, -0.1);
  EXPECT_EQ(rig.cycle(), -0.1);
  EXPECT_EQ(rig.input.selected(), kOperator);
  EXPECT_EQ(rig.say_for(280ms, kNavigation, 0.4), -0.1);
  EXPECT_EQ(rig.say_for(40ms, kNavigation, 0.4), 0.4);
  EXPECT_EQ(rig.input.stats().handovers, 2U);
  EXPECT_EQ(rig.input.stats().timeouts, 0U);
}

TEST(CommandInput, the_operators_zero_is_a_command) {
  Rig rig{navigation_and_operator()};
  rig.say(kOperator, 0.0);
  EXPECT_EQ(rig.say_for(100ms, kNavigation, 0.4), 0.0);
  EXPECT_EQ(rig.input.selected(), kOperator);
}

TEST(CommandInput, an_operators_zero_stops_navigation_without_a_rest_before_it_and_arms_nothing) {
  Rig rig{navigation_and_operator(RearmRule::Neutral)};
  rig.cycle(1s);
  ASSERT_EQ(rig.say_for(100ms, kNavigation, 0.4), 0.4);
  rig.say(kOperator, 0.0);
  EXPECT_EQ(rig.say_for(280ms, kNavigation, 0.4), 0.0);
  EXPECT_EQ(rig.input.selected(), kOperator);
  EXPECT_EQ(rig.input.state(), State::Waiting);
  EXPECT_EQ(rig.say_for(100ms, kNavigation, 0.4), 0.4) << "the operator's timeout is over";
  EXPECT_EQ(rig.input.stats().timeouts, 0U);
  // Motion right behind the zero still needs its rest.
  rig.say(kOperator, 0.0);
  rig.cycle();
  Rig impatient{navigation_and_operator(RearmRule::Neutral)};
  impatient.say(kOperator, 0.0);
  impatient.cycle();
  EXPECT_EQ(impatient.say_for(100ms, kOperator, 0.2), 0.0);
}

TEST(CommandInput, a_lock_blocks_lower_priorities_only) {
  Rig rig{navigation_and_operator()};
  rig.say_for(100ms, kNavigation, 0.4);
  rig.inbox.locks[0].locked = true;
  EXPECT_EQ(rig.say_for(100ms, kNavigation, 0.4), 0.0);
  EXPECT_EQ(rig.input.state(), State::Locked);
  EXPECT_EQ(rig.say_for(100ms, kOperator, 0.2), 0.2);
  rig.inbox.locks[0].locked = false;
  rig.cycle(1s);
  EXPECT_EQ(rig.say_for(100ms, kNavigation, 0.4), 0.4);
}

TEST(CommandInput, a_lock_with_a_timeout_is_locked_until_its_first_message) {
  auto settings = navigation_and_operator();
  settings.locks[0].timeout = 200ms;
  Rig rig{settings};
  EXPECT_EQ(rig.say_for(100ms, kNavigation, 0.4), 0.0);
  rig.inbox.locks[0].heard_at_ns = rig.now.nanoseconds();
  EXPECT_EQ(rig.say_for(180ms, kNavigation, 0.4), 0.4);
  EXPECT_EQ(rig.say_for(100ms, kNavigation, 0.4), 0.0);
}

TEST(CommandInput, after_a_stop_each_input_is_armed_by_its_own_rest) {
  Rig rig{navigation_and_operator(RearmRule::Neutral)};
  rig.now += 1s;
  EXPECT_EQ(rig.say_for(200ms, kNavigation, 0.4), 0.4);
  rig.set_emergency(true);
  rig.say_for(100ms, kNavigation, 0.4);
  rig.set_emergency(false);
  EXPECT_EQ(rig.say_for(500ms, kNavigation, 0.4), 0.0);
  rig.say(kOperator, 0.2);  // it was silent all the time
  EXPECT_EQ(rig.say_for(100ms, kNavigation, 0.4), 0.2);
  EXPECT_EQ(rig.say_for(1s, kNavigation, 0.4), 0.0) << "navigation has not rested";
}

TEST(CommandInput, wants_no_motion_during_a_hold_nor_until_a_command_after_it) {
  const unsigned seed = 20261122;
  std::mt19937 random{seed};
  Rig rig{navigation_and_operator(RearmRule::Neutral)};
  MonotonicTime released{};
  MonotonicTime restless[2]{};
  for (int step = 0; step < 50000; ++step) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", step " << step);
    const bool was_set = rig.inbox.emergency_stop.is_set;
    if (random() % 40 == 0) {
      rig.set_emergency(!was_set);
      if (was_set) released = rig.now;
      rig.now += 1ns;
    }
    const MonotonicTime said_at = rig.now;
    for (std::size_t source : {kNavigation, kOperator}) {
      if (random() % 3 == 0) continue;
      const double speed = random() % 2 == 0 ? 0.0 : 0.1;
      rig.say(source, speed);
      if (speed != 0.0) restless[source] = said_at;
    }
    const double wanted = rig.cycle(Duration{random() % 300'000'000});
    if (rig.inbox.emergency_stop.is_set) {
      ASSERT_EQ(wanted, 0.0);
    } else if (wanted != 0.0) {
      ASSERT_NE(rig.input.selected(), CommandInput::kNobody);
      ASSERT_GE(restless[rig.input.selected()], released) << "it moves on a command from before the release";
    }
  }
  EXPECT_GT(rig.input.stats().taken, 100U);
  EXPECT_GT(rig.input.stats().disarmed, 100U);
}

}  // namespace
}  // namespace nacelle::diff_drive
