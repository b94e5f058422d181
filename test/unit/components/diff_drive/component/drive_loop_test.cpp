// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/drive_loop.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "../port/base_rig.hpp"

namespace nacelle::diff_drive {
namespace {

/// Records commands, fails on request, and advances time without waiting.
class RecordingPort final : public BasePort {
 public:
  explicit RecordingPort(ToldClock& clock) : clock_(clock) {}

  Result<void, BaseFault> start() override {
    ++starts;
    return {};
  }
  Result<void, BaseFault> read_until(MonotonicTime deadline, WheelStateSink& sink) override {
    if (read_fault) return err(*read_fault);
    clock_.set(deadline + late);
    if (board_fault) sink.on_board_fault(*board_fault);
    if (speaks) sink.on_wheel_state({0, 0, {}, 12.0, clock_.now()});
    return {};
  }
  Result<void, BaseFault> write(const WheelRates& rates) override {
    if (write_fault) return err(*write_fault);
    clock_.advance(write_time);
    commands.push_back(rates);
    return {};
  }
  Result<void, BaseFault> stop() override {
    ++stops;
    return write({});
  }
  Result<void, BaseFault> reopen() override {
    ++reopens;
    if (read_fault || write_fault) return err(BaseFault::LineLost);
    return {};
  }
  void rest_until(MonotonicTime deadline) override { clock_.set(deadline); }
  void interrupt() noexcept override {}
  double max_wheel_rate() const override { return most_rps; }
  ByteView stop_frame() const override { return {}; }
  int descriptor() const noexcept override { return -1; }
  Stats stats() const override { return {}; }
  std::string why_no_state(Duration) const override { return why; }

  std::string why;
  std::vector<WheelRates> commands;
  int stops = 0;
  int starts = 0;
  int reopens = 0;
  bool speaks = true;
  Duration late{};
  Duration write_time{};
  double most_rps = std::numeric_limits<double>::infinity();
  std::optional<BaseFault> read_fault, write_fault;
  std::optional<const char*> board_fault;  ///< Said with each state; null inside: the board has none.

 private:
  ToldClock& clock_;
};

class Watching final : public DriveObserver {
 public:
  void on_wheel_state(const WheelState&) override { ++states; }
  void on_cycle(const BodyTwist& commanded, MonotonicTime) override { twists.push_back(commanded); }
  void on_command_written(Duration since_published) override { latencies.push_back(since_published); }
  void on_board_lost(std::string_view why) override { losses.emplace_back(why); }
  void on_board_back(MonotonicTime) override { ++returns; }
  int states = 0;
  std::vector<std::string> losses;
  int returns = 0;
  std::vector<BodyTwist> twists;
  std::vector<Duration> latencies;
};

struct LoopRig {
  explicit LoopRig(const DriveLoop::Settings& settings = {}) : loop(settings, port, clock, inbox, watching) {
    loop.arm(clock.now());
  }
  void command(double linear_mps, double angular_rps = 0.0) {
    inbox.sources[0].commands.put({{linear_mps, angular_rps}, clock.now(), clock.now()});
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) ASSERT_TRUE(loop.cycle());
  }

  ToldClock clock;
  RecordingPort port{clock};
  CommandInbox inbox;
  Watching watching;
  DriveLoop loop;
};

DriveLoop::Settings with_limits(double velocity, double acceleration, double deceleration) {
  AxisLimits linear;
  linear.max_velocity = velocity;
  linear.max_acceleration = acceleration;
  linear.max_deceleration = deceleration;
  DriveLoop::Settings settings;
  settings.limits = {resolved(linear).value(), resolved({}).value()};
  return settings;
}

TEST(DriveLoop, commands_only_stops_before_the_first_command) {
  LoopRig rig;
  rig.cycles(10);
  EXPECT_EQ(rig.port.commands.size(), 10U);
  EXPECT_EQ(rig.port.stops, 10);
}

TEST(DriveLoop, turns_a_command_into_wheel_rates) {
  LoopRig rig;
  rig.command(0.3, 0.5);
  rig.cycles(1);
  const DriveGeometry drive;
  EXPECT_EQ(rig.port.commands.back(), wheel_rates(drive, {0.3, 0.5}));
}

TEST(DriveLoop, keeps_its_rate_on_absolute_instants) {
  LoopRig rig;
  rig.port.late = 3ms;
  rig.cycles(500);
  EXPECT_EQ(rig.clock.now(), (MonotonicTime{100s + 500 * 20ms + 3ms}));
  EXPECT_EQ(rig.loop.stats().skipped, 0U);
}

TEST(DriveLoop, skips_the_periods_that_a_late_cycle_slept_through) {
  LoopRig rig;
  rig.port.late = 45ms;
  rig.cycles(1);
  rig.port.late = 0ms;
  rig.cycles(1);
  EXPECT_EQ(rig.loop.stats().skipped, 2U);
  EXPECT_EQ(rig.clock.now(), (MonotonicTime{100s + 80ms}));
}

TEST(DriveLoop, is_at_zero_one_cycle_after_the_timeout_whatever_the_deceleration) {
  LoopRig rig{with_limits(1.0, 5.0, -1.0)};
  rig.command(0.5);
  rig.cycles(25);  // 500 ms: the command has just not expired
  EXPECT_EQ(rig.watching.twists.back().linear_mps, 0.5);
  rig.cycles(1);
  EXPECT_EQ(rig.port.commands.back(), WheelRates{});
  EXPECT_EQ(rig.loop.command_state(), CommandInput::State::TimedOut);
  rig.cycles(100);
  EXPECT_EQ(rig.watching.twists.back(), BodyTwist{}) << "it stays stopped";
  rig.command(0.1);
  rig.cycles(10);
  EXPECT_EQ(rig.watching.twists.back().linear_mps, 0.1);
}

TEST(DriveLoop, a_command_of_zero_obeys_the_deceleration) {
  LoopRig rig{with_limits(1.0, 5.0, -1.0)};
  rig.command(0.5);
  rig.cycles(20);
  rig.command(0.0);
  rig.cycles(1);
  EXPECT_NEAR(rig.watching.twists.back().linear_mps, 0.5 - 1.0 * 0.02, 1e-12);
}

TEST(DriveLoop, an_emergency_stop_is_on_the_wire_in_the_same_cycle_and_stays) {
  LoopRig rig{with_limits(1.0, 5.0, -1.0)};
  rig.command(0.5);
  rig.cycles(20);
  rig.inbox.emergency_stop.set();
  rig.command(0.5);
  rig.cycles(1);
  EXPECT_EQ(rig.port.commands.back(), WheelRates{});
  for (int i = 0; i < 50; ++i) {
    rig.command(0.5);
    rig.cycles(1);
    ASSERT_EQ(rig.port.commands.back(), WheelRates{});
  }
  EXPECT_EQ(rig.loop.look().state, CommandInput::State::Held);
  EXPECT_EQ(rig.loop.look().holds, static_cast<std::uint8_t>(Hold::EmergencyStop));
}

TEST(DriveLoop, a_stop_from_outside_holds_until_it_is_armed_anew) {
  LoopRig rig;
  std::atomic<std::uint64_t> stops{3};
  rig.inbox.stops_from_outside = &stops;
  rig.loop.arm(rig.clock.now());
  rig.command(0.3);
  rig.cycles(1);
  ASSERT_NE(rig.port.commands.back(), WheelRates{});
  const int told = rig.port.stops;
  ++stops;
  rig.command(0.3);
  rig.cycles(1);
  EXPECT_GT(rig.port.stops, told);
  EXPECT_EQ(rig.port.commands.back(), WheelRates{});
  EXPECT_EQ(rig.loop.look().holds, static_cast<std::uint8_t>(Hold::Stopped));
  rig.cycles(100);
  rig.command(0.3);
  rig.cycles(1);
  EXPECT_EQ(rig.port.commands.back(), WheelRates{});

  rig.loop.arm(rig.clock.now());
  rig.command(0.3);
  rig.cycles(1);
  EXPECT_NE(rig.port.commands.back(), WheelRates{});
}

// A stopped process, a suspended machine: commands that queued up meanwhile do not express a present wish to move.
TEST(DriveLoop, after_an_absence_the_inputs_must_have_been_neutral) {
  DriveLoop::Settings settings;
  settings.input.rearm = RearmRule::Neutral;
  settings.motor_watchdog = 300ms;  // shorter than the input's timeout
  LoopRig rig{settings};
  rig.cycles(26);
  rig.command(0.3);
  rig.cycles(1);
  ASSERT_NE(rig.port.commands.back(), WheelRates{});
  rig.port.late = 280ms;  // and a cycle itself: at the limit
  rig.cycles(1);
  ASSERT_NE(rig.port.commands.back(), WheelRates{});
  rig.command(0.3);
  rig.port.late = 281ms;
  rig.cycles(1);
  rig.port.late = {};
  EXPECT_EQ(rig.port.commands.back(), WheelRates{});
  EXPECT_EQ(rig.loop.look().state, CommandInput::State::TimedOut);
  for (int i = 0; i < 50; ++i) {
    rig.command(0.3);
    rig.cycles(1);
    ASSERT_EQ(rig.port.commands.back(), WheelRates{}) << "a sender that goes on is not followed";
  }
  rig.cycles(26);
  rig.command(0.3);
  rig.cycles(1);
  EXPECT_NE(rig.port.commands.back(), WheelRates{});
}

TEST(DriveLoop, a_lost_line_is_opened_again_and_what_was_commanded_does_not_go_on) {
  DriveLoop::Settings settings;
  settings.reopen_limit = 60s;
  settings.input.rearm = RearmRule::Neutral;
  LoopRig rig{settings};
  rig.clock.advance(1s);  // silent before
  rig.loop.arm(rig.clock.now());
  rig.inbox.sources[0].commands.put({{0.5, 0.0}, rig.clock.now(), rig.clock.now(), true});
  rig.cycles(1);
  ASSERT_NE(rig.port.commands.back(), WheelRates{});

  rig.port.read_fault = BaseFault::LineLost;
  const auto written = rig.port.commands.size();
  for (int i = 0; i < 50; ++i) {
    rig.command(0.5);
    rig.cycles(1);
  }
  EXPECT_LE(rig.port.commands.size(), written + 1) << "one attempt to stop, then nothing";
  EXPECT_GE(rig.port.reopens, 4);

  rig.port.read_fault.reset();
  for (int i = 0; i < 50; ++i) {
    rig.command(0.5);
    rig.cycles(1);
    ASSERT_EQ(rig.port.commands.back(), WheelRates{}) << "cycle " << i;
  }
  EXPECT_EQ(rig.loop.stats().reopened, 1U);
  EXPECT_TRUE(rig.loop.look().waits_for_neutral);
  rig.cycles(26);  // silent for the timeout of 500 ms
  rig.command(0.5);
  rig.cycles(1);
  EXPECT_NE(rig.port.commands.back(), WheelRates{});
}

TEST(DriveLoop, gives_a_line_up_that_does_not_come_back) {
  DriveLoop::Settings settings;
  settings.reopen_limit = 2s;
  LoopRig rig{settings};
  rig.port.read_fault = BaseFault::LineLost;
  Result<void, DriveFault> last;
  int cycles = 0;
  while (last && cycles < 1000) {
    last = rig.loop.cycle();
    ++cycles;
  }
  ASSERT_FALSE(last);
  EXPECT_STREQ(code_of(last.error().kind), "SERIAL_LOST");
  EXPECT_NEAR(cycles, 101, 1);
}

TEST(DriveLoop, a_command_from_before_it_was_armed_moves_nothing) {
  LoopRig rig;
  rig.command(0.5);
  rig.clock.advance(1ms);
  rig.loop.arm(rig.clock.now());
  rig.cycles(10);
  EXPECT_EQ(rig.port.stops, 10);
  EXPECT_EQ(rig.loop.stats().commands.early, 1U);
}

TEST(DriveLoop, arming_again_forgets_the_speed_and_the_command) {
  LoopRig rig{with_limits(1.0, 1.0, -1.0)};
  rig.command(0.5);
  rig.cycles(20);
  rig.loop.arm(rig.clock.now());
  rig.cycles(1);
  EXPECT_EQ(rig.watching.twists.back(), BodyTwist{});
}

TEST(DriveLoop, keeps_the_curve_when_a_wheel_would_be_too_fast) {
  LoopRig rig;
  rig.port.most_rps = 10.0;
  rig.command(1.0, 2.0);
  rig.cycles(1);
  const BodyTwist twist = rig.watching.twists.back();
  EXPECT_NEAR(twist.angular_rps / twist.linear_mps, 2.0, 1e-12);
  EXPECT_NEAR(rig.port.commands.back().right_rps, 10.0, 1e-9);
}

TEST(DriveLoop, tells_how_long_each_command_took_to_the_end_of_its_write) {
  LoopRig rig;
  rig.port.write_time = 2ms;
  rig.command(0.5);
  rig.cycles(3);
  ASSERT_EQ(rig.watching.latencies.size(), 1U) << "once per command";
  EXPECT_EQ(rig.watching.latencies[0], Duration{22ms});
}

TEST(DriveLoop, counts_a_superseded_command_in_no_latency) {
  LoopRig rig;
  rig.command(0.5);
  rig.command(0.4);
  rig.cycles(1);
  EXPECT_EQ(rig.watching.latencies.size(), 1U);
  EXPECT_NEAR(rig.port.commands.back().left_rps, 0.4 / 0.033, 1e-9);
}

TEST(DriveLoop, a_stuck_line_is_tried_again_and_the_command_counts_when_it_got_through) {
  LoopRig rig;
  rig.command(0.5);
  rig.port.write_fault = BaseFault::LineStuck;
  rig.cycles(5);
  EXPECT_TRUE(rig.watching.latencies.empty());
  rig.port.write_fault.reset();
  rig.cycles(1);
  ASSERT_EQ(rig.watching.latencies.size(), 1U);
  EXPECT_EQ(rig.watching.latencies[0], Duration{120ms});
  EXPECT_EQ(rig.loop.stats().unwritten, 5U);
}

TEST(DriveLoop, gives_a_line_up_that_stays_stuck) {
  LoopRig rig;
  rig.port.write_fault = BaseFault::LineStuck;
  Result<void, DriveFault> last;
  int cycles = 0;
  while (last && cycles < 1000) {
    last = rig.loop.cycle();
    ++cycles;
  }
  ASSERT_FALSE(last);
  EXPECT_EQ(last.error().kind, DriveFault::Kind::SerialStuck);
  EXPECT_EQ(cycles, 51) << "one second";
}

TEST(DriveLoop, faults_and_stops_when_the_line_is_lost) {
  LoopRig rig;
  rig.command(0.5);
  rig.cycles(1);
  rig.port.read_fault = BaseFault::LineLost;
  const auto lost = rig.loop.cycle();
  ASSERT_FALSE(lost);
  EXPECT_STREQ(code_of(lost.error().kind), "SERIAL_LOST");
  EXPECT_EQ(rig.port.commands.back(), WheelRates{});
}

TEST(DriveLoop, faults_and_stops_when_the_board_falls_silent) {
  LoopRig rig;
  rig.command(0.5);
  rig.port.speaks = false;
  Result<void, DriveFault> last;
  int cycles = 0;
  while (last && cycles < 1000) {
    last = rig.loop.cycle();
    ++cycles;
  }
  ASSERT_FALSE(last);
  EXPECT_STREQ(code_of(last.error().kind), "FEEDBACK_LOST");
  EXPECT_EQ(rig.port.commands.back(), WheelRates{});
  EXPECT_EQ(cycles, 51);
}

DriveLoop::Settings waiting() {
  DriveLoop::Settings settings;
  settings.waits_for_board = true;
  settings.input.rearm = RearmRule::Neutral;
  return settings;
}

/// Commands in every cycle, as a sender does that notices nothing.
void drive_on(LoopRig& rig, int cycles) {
  for (int i = 0; i < cycles; ++i) {
    rig.command(0.5);
    rig.cycles(1);
  }
}

void rests_and_moves_again(LoopRig& rig) {
  drive_on(rig, 50);
  EXPECT_EQ(rig.port.commands.back(), WheelRates{}) << "a sender that never rested moves nothing";
  rig.cycles(26);
  drive_on(rig, 1);
  EXPECT_NE(rig.port.commands.back(), WheelRates{});
}

TEST(DriveLoop, a_silent_board_gets_zero_is_reopened_without_limit_and_moves_only_after_a_rest) {
  LoopRig rig{waiting()};
  rig.cycles(26);
  drive_on(rig, 2);
  ASSERT_NE(rig.port.commands.back(), WheelRates{});
  rig.port.speaks = false;
  drive_on(rig, 25);
  EXPECT_TRUE(rig.watching.losses.empty()) << "half a second is not too long";
  drive_on(rig, 1);
  EXPECT_EQ(rig.watching.losses, std::vector<std::string>{"the motor board says nothing"});
  EXPECT_EQ(rig.port.commands.back(), WheelRates{});

  drive_on(rig, 5000);
  EXPECT_GE(rig.port.starts, 99) << "once a second";
  EXPECT_EQ(rig.port.commands.back(), WheelRates{});
  EXPECT_EQ(rig.watching.losses.size(), 1U);
  rig.port.speaks = true;
  drive_on(rig, 2);
  EXPECT_EQ(rig.watching.returns, 1);
  rests_and_moves_again(rig);
}

TEST(DriveLoop, reports_what_the_port_knows_of_a_silent_board_also_behind_a_line_that_is_back) {
  LoopRig rig{waiting()};
  rig.port.speaks = false;
  rig.port.why = "it is a LiDAR";
  rig.cycles(26);
  EXPECT_EQ(rig.watching.losses, std::vector<std::string>{"it is a LiDAR"});

  rig.port.read_fault = rig.port.write_fault = BaseFault::LineLost;
  rig.cycles(100);
  rig.port.read_fault.reset();
  rig.port.write_fault.reset();
  rig.watching.losses.clear();
  rig.cycles(200);
  EXPECT_EQ(rig.watching.losses, std::vector<std::string>{"it is a LiDAR"}) << "once";
}

TEST(DriveLoop, a_pulled_cable_is_waited_for_without_limit_and_is_back_when_the_board_speaks) {
  LoopRig rig{waiting()};
  rig.cycles(26);
  drive_on(rig, 2);
  rig.port.read_fault = BaseFault::LineLost;
  rig.port.write_fault = BaseFault::LineLost;
  drive_on(rig, 5000);
  EXPECT_GE(rig.port.reopens, 99) << "once a second";
  rig.port.read_fault.reset();
  rig.port.write_fault.reset();
  drive_on(rig, 100);
  EXPECT_EQ(rig.loop.stats().reopened, 1U);
  EXPECT_EQ(rig.watching.returns, 1);
  rests_and_moves_again(rig);
}

TEST(DriveLoop, a_line_that_takes_nothing_for_half_a_second_is_a_lost_board) {
  LoopRig rig{waiting()};
  rig.cycles(26);
  drive_on(rig, 2);
  rig.port.write_fault = BaseFault::LineStuck;
  drive_on(rig, 26);
  ASSERT_EQ(rig.watching.losses.size(), 1U);
  EXPECT_EQ(rig.watching.losses[0], explain(BaseFault::LineStuck));
  rig.port.write_fault.reset();
  drive_on(rig, 2);
  EXPECT_EQ(rig.watching.returns, 1);
  rests_and_moves_again(rig);
}

TEST(DriveLoop, a_loop_that_was_away_takes_its_own_absence_for_no_silence_of_the_board) {
  LoopRig rig{waiting()};
  rig.cycles(26);
  rig.clock.advance(3s);
  rig.cycles(2);
  EXPECT_TRUE(rig.watching.losses.empty());
}

TEST(DriveLoop, begins_without_a_board_and_takes_it_when_it_speaks) {
  LoopRig rig{waiting()};
  rig.port.speaks = false;
  rig.loop.arm(rig.clock.now());
  rig.loop.begin_without_board();
  drive_on(rig, 100);
  EXPECT_GE(rig.port.starts, 1);
  rig.port.speaks = true;
  drive_on(rig, 2);
  EXPECT_EQ(rig.watching.returns, 1);
  rests_and_moves_again(rig);
}

TEST(DriveLoop, hears_every_state_that_comes_between_two_cycles) {
  ToldClock clock;
  LoopbackPort port{clock, {4ms, 12.0}, [&](MonotonicTime until) { clock.set(until); }};
  CommandInbox inbox;
  Watching watching;
  DriveLoop loop{{}, port, clock, inbox, watching};
  loop.arm(clock.now());
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(loop.cycle());
  EXPECT_EQ(watching.states, 250);
}

TEST(DriveLoop, drives_perfect_wheels_around_a_circle) {
  ToldClock clock;
  LoopbackPort port{clock, {}, [&](MonotonicTime until) { clock.set(until); }};
  CommandInbox inbox;
  Watching watching;
  DriveLoop::Settings settings;
  settings.input.sources[0].timeout = 0s;
  DriveLoop loop{settings, port, clock, inbox, watching};
  loop.arm(clock.now());
  inbox.sources[0].commands.put({{0.2, 0.4}, clock.now(), clock.now()});
  for (int i = 0; i < 501; ++i) ASSERT_TRUE(loop.cycle());
  Heard heard;
  static_cast<void>(port.read_until(clock.now() + 20ms, heard));
  // From the first cycle's end to here: 10.02 s.
  const BodyTwist driven = body_twist(settings.geometry, {heard.states.back().left_rad, heard.states.back().right_rad});
  EXPECT_NEAR(driven.linear_mps, 0.2 * 10.02, 1e-6);
  EXPECT_NEAR(driven.angular_rps, 0.4 * 10.02, 1e-6);
}

TEST(DriveLoop, a_fault_of_the_board_stops_the_wheels_at_once_and_until_a_new_command) {
  LoopRig rig{with_limits(10.0, 1.0, -1.0)};
  rig.port.board_fault = nullptr;
  rig.command(5.0);
  rig.cycles(10);
  EXPECT_GT(rig.watching.twists.back().linear_mps, 0.0);

  const int stops = rig.port.stops;
  rig.port.board_fault = "driver fault";
  rig.cycles(1);
  EXPECT_EQ(rig.port.stops, stops + 2) << "at once, and in the cycle; not down a ramp";
  EXPECT_EQ(rig.watching.twists.back(), BodyTwist{});
  EXPECT_STREQ(rig.loop.board_fault(), "driver fault");
  EXPECT_EQ(rig.loop.look().holds, static_cast<std::uint8_t>(Hold::BoardFault));
  rig.command(5.0);
  rig.cycles(3);
  EXPECT_EQ(rig.watching.twists.back(), BodyTwist{}) << "a command does not overrule the board";
  EXPECT_EQ(rig.loop.stats().board_faults, 1U);

  rig.port.board_fault = nullptr;
  rig.cycles(1);
  EXPECT_EQ(rig.loop.board_fault(), nullptr);
  EXPECT_EQ(rig.watching.twists.back(), BodyTwist{}) << "the old command is not resumed";
  rig.command(5.0);
  rig.cycles(1);
  EXPECT_GT(rig.watching.twists.back().linear_mps, 0.0);
}

}  // namespace
}  // namespace nacelle::diff_drive
