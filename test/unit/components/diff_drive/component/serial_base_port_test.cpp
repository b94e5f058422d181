// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/serial_base_port.hpp"

#include <gtest/gtest.h>

#include "../port/base_rig.hpp"
#include "diff_drive/component/vesc_board.hpp"
#include "nacelle/io/scripted_stream.hpp"
#include "simulation/protocol/vesc_device.hpp"

namespace nacelle::diff_drive {
namespace {

using io::ScriptedStream;

/// A port to a Waveshare board whose line is written down beforehand.
struct ScriptedPort {
  explicit ScriptedPort(Duration byte_time = {}, std::optional<io::ExpectedDevice> expected = {}) {
    auto made =
        std::make_unique<ScriptedStream>(std::vector<ScriptedStream::Step>{}, ScriptedStream::AtEnd::Silence,
                                         [this](MonotonicTime until) { clock.set(std::max(clock.now(), until)); });
    line = made.get();
    SerialBasePort::Settings settings;
    settings.byte_time = byte_time;
    settings.expected = std::move(expected);
    port = std::make_unique<SerialBasePort>(
        std::move(made), std::make_unique<WaveshareBoard>(WaveshareBoard::Settings{0.05}), clock, settings);
  }
  void say(Duration at, const std::string& text) {
    const ByteView bytes = as_bytes(text);
    line->append({{100s + at}, Bytes(bytes.begin(), bytes.end())});
  }
  WheelState hear(Duration until) {
    Heard heard;
    EXPECT_TRUE(port->read_until({100s + until}, heard));
    return heard.states.empty() ? WheelState{} : heard.states.back();
  }
  std::string written() const {
    const Bytes bytes = line->written();
    return std::string(as_text(bytes));
  }

  ToldClock clock;
  ScriptedStream* line = nullptr;
  std::unique_ptr<SerialBasePort> port;
};

std::string feedback(double left_mps, double left_m) {
  return "{\"T\":1001,\"L\":" + std::to_string(left_mps) + ",\"R\":0,\"odl\":" + std::to_string(left_m) +
         ",\"odr\":0,\"v\":11.5}\n";
}

TEST(SerialBasePort, starts_with_a_stop_and_asks_for_what_it_needs) {
  ScriptedPort rig;
  ASSERT_TRUE(rig.port->start());
  EXPECT_EQ(rig.written(),
            "\n{\"T\":1,\"L\":0,\"R\":0}\n{\"T\":143,\"cmd\":0}\n{\"T\":131,\"cmd\":1}\n{\"T\":136,\"cmd\":500}\n");
}

TEST(SerialBasePort, gives_radians_of_the_wheel) {
  ScriptedPort rig;
  ASSERT_TRUE(rig.port->start());
  rig.say(10ms, feedback(0.5, 1.0));
  const WheelState state = rig.hear(1s);
  EXPECT_NEAR(state.left_rad, 20.0, 1e-9);
  EXPECT_NEAR(state.rates.left_rps, 10.0, 1e-9);
  EXPECT_EQ(state.voltage_v, 11.5);
  EXPECT_EQ(state.captured_at, MonotonicTime{100s + 10ms});
}

TEST(SerialBasePort, takes_the_time_on_the_line_off_the_stamp) {
  ScriptedPort rig{100us};
  ASSERT_TRUE(rig.port->start());
  const std::string line = feedback(0.5, 1.0);
  rig.say(50ms, "{\"T\":1002}\n" + line);
  EXPECT_EQ(rig.hear(1s).captured_at, MonotonicTime{100s + 50ms} - static_cast<std::int64_t>(line.size()) * 100us);
  rig.say(70ms, line);
  EXPECT_EQ(rig.hear(1s).captured_at, MonotonicTime{100s + 70ms} - static_cast<std::int64_t>(line.size()) * 100us);
}

TEST(SerialBasePort, spaces_the_lines_of_one_chunk_as_they_were_sent) {
  ScriptedPort rig{100us};
  ASSERT_TRUE(rig.port->start());
  const std::string line = feedback(0.5, 1.0);
  rig.say(90ms, line + line + line);
  Heard heard;
  ASSERT_TRUE(rig.port->read_until({101s}, heard));
  ASSERT_EQ(heard.states.size(), 3U);
  const Duration line_time = static_cast<std::int64_t>(line.size()) * 100us;
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(heard.states[i].captured_at, MonotonicTime{100s + 90ms} - (3 - i) * line_time) << i;
}

TEST(SerialBasePort, goes_on_counting_when_the_board_was_reset) {
  ScriptedPort rig;
  ASSERT_TRUE(rig.port->start());
  rig.say(20ms, feedback(0.5, 12.0));
  rig.say(40ms, feedback(0.5, 12.01));
  rig.say(60ms, feedback(0.5, 0.0));
  rig.say(80ms, feedback(0.5, 0.01));
  for (int i = 0; i < 3; ++i) rig.hear(1s);
  EXPECT_NEAR(rig.hear(1s).left_rad, (12.01 + 0.01) / 0.05, 1e-6);
  EXPECT_EQ(rig.port->stats().board_restarts, 1U);
}

TEST(SerialBasePort, integrates_the_speeds_of_a_board_that_sends_only_speeds) {
  ScriptedPort rig;
  ASSERT_TRUE(rig.port->start());
  for (int i = 0; i <= 50; ++i) rig.say(i * 20ms, "{\"T\":1001,\"L\":0.5,\"R\":-0.25,\"v\":12}\n");
  WheelState state;
  for (int i = 0; i <= 50; ++i) state = rig.hear(10s);
  EXPECT_NEAR(state.left_rad, 0.5 / 0.05, 1e-9);
  EXPECT_NEAR(state.right_rad, -0.25 / 0.05, 1e-9);
}

TEST(SerialBasePort, ends_a_torn_line_before_the_next_command) {
  ScriptedPort rig;
  ASSERT_TRUE(rig.port->start());
  rig.line->fail_writes(io::StreamFault::WouldBlock);
  EXPECT_EQ(rig.port->write({1.0, 1.0}).error(), BaseFault::LineStuck);
  rig.line->fail_writes(std::nullopt);
  const std::size_t before = rig.written().size();
  ASSERT_TRUE(rig.port->stop());
  EXPECT_EQ(rig.written().substr(before), "\n{\"T\":1,\"L\":0,\"R\":0}\n");
  ASSERT_TRUE(rig.port->stop());
  EXPECT_EQ(rig.written().substr(before), "\n{\"T\":1,\"L\":0,\"R\":0}\n{\"T\":1,\"L\":0,\"R\":0}\n");
}

TEST(SerialBasePort, commands_do_not_queue_for_a_deaf_board_and_a_stop_goes_first) {
  ScriptedPort rig;
  ASSERT_TRUE(rig.port->start());
  const std::size_t before = rig.written().size();
  rig.line->hold_writes(true);
  EXPECT_TRUE(rig.port->write({1.0, 1.0}));
  for (int i = 0; i < 400; ++i) {
    rig.clock.set(rig.clock.now() + 20ms);
    const auto written = rig.port->write({1.0 + 0.01 * i, 1.0});
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error(), BaseFault::LineStuck) << "the queue is full for as long as it is not taken";
    EXPECT_LT(rig.line->unsent(), 40U) << "the newest command alone";
  }
  rig.clock.set(rig.clock.now() + 20ms);
  EXPECT_FALSE(rig.port->stop());
  rig.line->hold_writes(false);
  EXPECT_EQ(rig.written().substr(before), "\n{\"T\":1,\"L\":0,\"R\":0}\n");
  EXPECT_TRUE(rig.port->write({1.0, 1.0}));
}

TEST(SerialBasePort, a_slow_line_gets_one_command_at_a_time_and_a_stop_at_once) {
  ScriptedPort rig{1ms};
  ASSERT_TRUE(rig.port->start());
  const std::size_t before = rig.written().size();
  rig.clock.set(rig.clock.now() + 1s);
  rig.line->hold_writes(true);
  ASSERT_TRUE(rig.port->write({1.0, 1.0}));
  const std::size_t one = rig.line->unsent();
  rig.clock.set(rig.clock.now() + 10ms);
  EXPECT_TRUE(rig.port->write({2.0, 2.0})) << "its turn is the next cycle";
  EXPECT_EQ(rig.line->unsent(), one);
  EXPECT_TRUE(rig.port->stop());
  rig.line->hold_writes(false);
  EXPECT_EQ(rig.written().substr(before), "\n{\"T\":1,\"L\":0,\"R\":0}\n");
}

TEST(SerialBasePort, a_stop_overtakes_the_queue_of_a_terminal_without_a_reader) {
  WaveshareRig rig;
  ASSERT_TRUE(rig.port().start());
  for (int i = 0; i < 600; ++i) static_cast<void>(rig.port().write({1.0, 1.0}));
  ASSERT_TRUE(rig.port().stop());
  int stale = 0;
  for (bool is_stopped = false; !is_stopped;) {
    ASSERT_TRUE(rig.board.take_until(1));
    const bool moves = rig.board.lines.back().find("\"L\":0,") == std::string::npos;
    if (moves) ++stale;
    is_stopped = !moves && stale > 0;
  }
  EXPECT_LE(stale, 4095 / 27) << "no more than the other end's own buffer comes before it";
}

io::ExpectedDevice expected_board() {
  return {.path = "/dev/ttyUSB0",
          .name = "waveshare",
          .usual_baud = 115200,
          .baud = 115200,
          .baud_parameter = "baud_rate",
          .when_silent = "is the motor board powered?"};
}

TEST(SerialBasePort, says_that_nothing_came) {
  ScriptedPort rig{{}, expected_board()};
  ASSERT_TRUE(rig.port->start());
  rig.hear(500ms);
  EXPECT_EQ(rig.port->why_no_state(500ms), "nothing came in 0.5 s; is the motor board powered?");
}

TEST(SerialBasePort, names_the_device_that_is_on_the_line_instead) {
  ScriptedPort rig{{}, expected_board()};
  ASSERT_TRUE(rig.port->start());
  const std::string frame{"\x55\x51\0\0\0\0\0\0\0\0\xA6", 11};  // of a WT901: its accelerometer reads zero
  for (int i = 1; i <= 5; ++i) rig.say(i * 10ms, frame);
  rig.hear(500ms);
  EXPECT_EQ(rig.port->why_no_state(500ms),
            "55 bytes came in 0.5 s, but no waveshare frame: they come from a WT901 IMU; is the waveshare on another "
            "line? nacelle device list shows what is plugged in");
}

TEST(SerialBasePort, does_not_take_half_of_a_board_for_another_device) {
  simulation::VescDevice vescs{simulation::VescDevice::Settings{}};
  vescs.cut_can(true);
  ToldClock clock;
  auto line = std::make_unique<ScriptedStream>(std::vector<ScriptedStream::Step>{}, ScriptedStream::AtEnd::Silence,
                                               [&](MonotonicTime until) { clock.set(std::max(clock.now(), until)); });
  line->answer_writes([&](ByteView bytes) { return vescs.on_bytes(bytes, clock.now().since_origin); });
  SerialBasePort::Settings settings;
  settings.expected = expected_board();
  SerialBasePort port{
      std::move(line),
      std::make_unique<VescBoard>(VescBoard::Settings{{{VescPrinter::kOnTheLine, false}, {42, false}, 90.0}}), clock,
      settings};
  ASSERT_TRUE(port.start());
  Heard heard;
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(port.read_until(clock.now() + 10ms, heard));
  EXPECT_GT(port.stats().bytes_in, 0U);
  EXPECT_EQ(port.why_no_state(500ms), "");
}

TEST(SerialBasePort, has_no_reason_once_the_board_was_heard_and_looks_anew_at_a_line_that_was_opened_again) {
  ScriptedPort rig{{}, expected_board()};
  ASSERT_TRUE(rig.port->start());
  rig.say(10ms, feedback(0.5, 1.0));
  rig.hear(500ms);
  EXPECT_EQ(rig.port->why_no_state(500ms), "");
  ASSERT_TRUE(rig.port->reopen());
  EXPECT_EQ(rig.port->why_no_state(500ms), "nothing came in 0.5 s; is the motor board powered?");
}

TEST(SerialBasePort, says_that_the_line_is_lost_when_the_other_end_hangs_up) {
  WaveshareRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.hang_up();
  Heard heard;
  const auto read = rig.port().read_until(rig.clock().now() + 2s, heard);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error(), BaseFault::LineLost);
  EXPECT_EQ(rig.port().write({1.0, 1.0}).error(), BaseFault::LineLost);
}

TEST(SerialBasePort, drops_lines_from_before_its_start) {
  WaveshareRig rig;
  rig.board.left_m = 5.0;
  rig.board.say(0.0);
  rig.board.send("{\"T\":1001,\"L\":1,");
  pollfd arrived{rig.port().descriptor(), POLLIN, 0};
  ASSERT_EQ(::poll(&arrived, 1, 2000), 1);
  ASSERT_TRUE(rig.port().start());
  EXPECT_EQ(rig.port().stats().states, 0U);
}

TEST(SerialBasePort, accounts_for_hostile_lines) {
  ScriptedPort rig;
  ASSERT_TRUE(rig.port->start());
  rig.say(1ms,
          "\x01\xff garbage\n" + std::string(3000, '{') + "\n{\"T\":1001,\"L\":1e999,\"R\":0}\n" + feedback(0.5, 0.1));
  EXPECT_NEAR(rig.hear(1s).rates.left_rps, 10.0, 1e-9);
  EXPECT_EQ(rig.port->stats().states, 1U);
  EXPECT_EQ(rig.port->stats().bytes_lost, 11U + 3001U + 27U);
}

}  // namespace
}  // namespace nacelle::diff_drive
