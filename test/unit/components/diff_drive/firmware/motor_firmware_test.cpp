// SPDX-License-Identifier: Apache-2.0
// Frames laid out by hand after docs/motor_board_protocol.md, with CRCs of Python's binascii.crc_hqx().
#include "diff_drive/firmware/motor_firmware.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "simulated_board.hpp"

namespace nacelle::diff_drive {
namespace {

Bytes bytes_of(std::string_view text) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(text, bytes)) << text;
  return bytes;
}
constexpr std::string_view kSpeedFrame = "a5 01 08 0000c03f 000020c0 374e";  // 1.5, -2.5 rad/s
constexpr std::string_view kStopFrame = "a5 02 00 6266";
constexpr std::string_view kSettingsFrame = "a5 03 04 c800 0a00 4a9e";  // 200 ms, 10 ms

struct Rig {
  void send(const Bytes& bytes) { sent = board.on_bytes(bytes, now); }
  void send(std::string_view text) { send(Bytes(text.begin(), text.end())); }
  /// Time passes in steps of 10 ms, and the wheels turn with their duties.
  void run(Duration length) {
    for (Duration done{}; done < length; done += 10ms) {
      now += 10ms;
      left_rad += 0.01 * board.left_target_rps() * load;
      right_rad += 0.01 * board.right_target_rps() * load;
      sent = board.step(now, left_rad, right_rad);
      if (!sent.empty()) reported = sent;
    }
  }
  SimulatedBoard board;
  Duration now{};
  double left_rad = 0.0, right_rad = 0.0;
  double load = 1.0;  ///< 1: the wheels turn freely.
  Bytes sent, reported;
};

TEST(MotorFirmware, obeys_frames_and_lines) {
  Rig rig;
  rig.run(20ms);
  rig.send(bytes_of(kSpeedFrame));
  rig.run(10ms);
  EXPECT_NEAR(rig.board.left_target_rps(), 1.5, 1e-5);
  EXPECT_NEAR(rig.board.right_target_rps(), -2.5, 1e-5);
  rig.send(bytes_of(kStopFrame));
  EXPECT_EQ(rig.board.left_target_rps(), 0.0) << "at once";
  rig.send("M 1.5 -2.5\n");
  rig.run(10ms);
  EXPECT_NEAR(rig.board.left_target_rps(), 1.5, 1e-5);
  rig.send("M 0 0\r\n");
  EXPECT_EQ(rig.board.right_target_rps(), 0.0);
}

TEST(MotorFirmware, its_watchdog_stops_the_wheels_of_a_silent_host) {
  Rig rig;
  rig.run(20ms);
  rig.send(bytes_of(kSpeedFrame));
  rig.run(500ms);
  EXPECT_NEAR(rig.board.left_target_rps(), 1.5, 1e-5);
  rig.run(20ms);
  EXPECT_EQ(rig.board.left_target_rps(), 0.0);
  EXPECT_TRUE(rig.board.firmware().is_stopped_by_watchdog());
  rig.send(bytes_of(kSettingsFrame));
  rig.run(20ms);
  EXPECT_EQ(rig.board.left_target_rps(), 0.0) << "only a command moves it again";
  rig.send(bytes_of(kSpeedFrame));
  rig.run(200ms);
  EXPECT_NEAR(rig.board.left_target_rps(), 1.5, 1e-5);
  rig.run(20ms);
  EXPECT_EQ(rig.board.left_target_rps(), 0.0) << "after the 200 ms that were set";
}

TEST(MotorFirmware, its_watchdog_works_across_the_wrap_of_the_clock) {
  Rig rig;
  rig.now = 4294967296ms - 300ms;
  rig.run(20ms);
  rig.send(bytes_of(kSpeedFrame));
  rig.run(400ms);
  EXPECT_NEAR(rig.board.left_target_rps(), 1.5, 1e-5);
  rig.run(120ms);
  EXPECT_EQ(rig.board.left_target_rps(), 0.0);
}

TEST(MotorFirmware, refuses_damaged_commands_and_those_that_are_no_speeds) {
  const Bytes frame = bytes_of(kSpeedFrame);
  for (std::size_t bit = 0; bit < frame.size() * 8; ++bit) {
    Rig rig;
    rig.run(20ms);
    Bytes damaged = frame;
    damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1U << (bit % 8)));
    rig.send(damaged);
    rig.run(20ms);
    ASSERT_EQ(rig.board.left_target_rps(), 0.0) << bit;
    ASSERT_EQ(rig.board.right_target_rps(), 0.0) << bit;
  }
  for (const char* line :
       {"M 1\n", "M 1 2 3\n", "M 1 x\n", "M nan 1\n", "M 1e9 1\n", "M 2000 0\n", "m 1 2\n", "M\n", "M 1 2.5.5\n"}) {
    Rig rig;
    rig.run(20ms);
    rig.send(std::string_view{line});
    rig.run(20ms);
    EXPECT_EQ(rig.board.left_target_rps(), 0.0) << line;
  }
  Rig rig;
  rig.run(20ms);
  rig.send(bytes_of("a5 01 08 0000c07f 00000000 f580"));
  rig.run(20ms);
  EXPECT_EQ(rig.board.left_target_rps(), 0.0) << "not a number";
}

TEST(MotorFirmware, finds_a_stop_behind_half_a_frame_and_half_a_line) {
  for (const bool is_text : {false, true}) {
    Rig rig;
    rig.run(20ms);
    rig.send(bytes_of(kSpeedFrame));
    rig.run(20ms);
    Bytes bytes = bytes_of(kSpeedFrame);
    bytes.resize(7);
    if (is_text) bytes = {'M', ' ', '1'};
    const Bytes stop = bytes_of(kStopFrame);
    bytes.insert(bytes.end(), 13, 0);
    bytes.insert(bytes.end(), stop.begin(), stop.end());
    rig.send(bytes);
    EXPECT_EQ(rig.board.left_target_rps(), 0.0);
  }
}

TEST(MotorFirmware, reports_in_the_language_of_its_host) {
  Rig rig;
  rig.run(20ms);
  rig.send(bytes_of(kSpeedFrame));
  rig.run(60ms);
  ASSERT_EQ(rig.reported.size(), 25U);
  EXPECT_EQ(to_hex(rig.reported).substr(0, 6), "a58114");
  rig.send("M 0 0\n");
  rig.run(60ms);
  const std::string text(as_text(rig.reported));
  EXPECT_EQ(text.substr(0, 2), "E ");
  EXPECT_NE(text.find("\nB 11.800\nF 0\n"), std::string::npos) << text;
}

TEST(MotorFirmware, a_fault_of_the_board_keeps_the_motors_off) {
  Rig rig;
  rig.run(20ms);
  rig.send(bytes_of(kSpeedFrame));
  rig.run(20ms);
  rig.board.fault_bits = 0x02;
  rig.run(20ms);
  EXPECT_EQ(rig.board.left_target_rps(), 0.0);
  rig.send(bytes_of(kSpeedFrame));
  rig.run(20ms);
  EXPECT_EQ(rig.board.left_target_rps(), 0.0);
}

TEST(MotorFirmware, its_controller_reaches_the_speed_under_load_and_does_not_wind_up) {
  Rig rig{.board = SimulatedBoard{
              {static_cast<float>(SimulatedBoard::kCounts), 1.0F / SimulatedBoard::kFull_rps, 0.005F, 0.1F}}};
  rig.load = 0.6;
  rig.run(20ms);
  rig.send("W 60000\n");
  rig.send("M 10 -10\n");
  rig.run(3000ms);
  EXPECT_NEAR(rig.board.left_target_rps() * rig.load, 10.0, 0.1);
  EXPECT_NEAR(rig.board.right_target_rps() * rig.load, -10.0, 0.1);
  rig.load = 0.0;  // blocked
  rig.run(20000ms);
  EXPECT_LE(rig.board.duties()[0], 1.0F);
  rig.load = 1.0;
  rig.run(2000ms);
  EXPECT_NEAR(rig.board.left_target_rps(), 10.0, 0.2);
}

TEST(MotorFirmware, any_bytes_leave_it_alive_and_stopped_by_its_watchdog) {
  std::mt19937 random{17};
  for (int round = 0; round < 300; ++round) {
    Rig rig;
    rig.run(20ms);
    Bytes bytes(random() % 200);
    for (auto& byte : bytes) byte = random() % 5 == 0 ? 0xA5 : static_cast<std::uint8_t>(random() % 40);
    rig.send(bytes);
    rig.send(bytes_of("a5 03 04 f401 1400 ddea"));
    rig.send("\nW 500\n");
    rig.run(600ms);
    ASSERT_EQ(rig.board.left_target_rps(), 0.0) << round;
    ASSERT_EQ(rig.board.right_target_rps(), 0.0) << round;
  }
}

}  // namespace
}  // namespace nacelle::diff_drive
