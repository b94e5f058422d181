// SPDX-License-Identifier: Apache-2.0
// Golden frames whose source is not ours:
//   [guide]  ODrive documentation of firmware 0.5.6, "CAN Bus Guide", the output of candump
//   [proto]  the same, "CAN Protocol": axis 1 with command 0x0C is 0x2C
//   [rust]   the documentation of the crate odrive_can_driver, example encode_decode
//   [dbc]    the documentation of the Python package odrive-can, made from ODrive's own .dbc file
#include "diff_drive/protocol/odrive_can.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace nacelle::diff_drive {
namespace {

CanFrame short_frame(std::uint32_t id, std::string_view hex) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(hex, bytes)) << hex;
  CanFrame frame;
  frame.id = id;
  frame.length = static_cast<std::uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

struct GoldenBeat {
  const char* source;
  std::uint32_t id;
  const char* data;
  OdriveHeartbeat means;
};
TEST(OdriveCan, reads_published_heartbeats) {
  const GoldenBeat table[] = {
      {"guide", 0x001, "00 00 00 00 01 00 00 00", {0, 0, 1}},  // idle
      {"guide", 0x021, "00 00 00 00 08 00 00 00", {1, 0, 8}},  // closed loop control
      {"rust", 0x021, "01 00 00 80 08 00 01 00", {1, 0x80000001, 8}},
      {"dbc", 0x001, "01 00 00 00 0b 00 00 00", {0, 1, 11}},  // INVALID_STATE, HOMING
  };
  for (const GoldenBeat& golden : table)
    EXPECT_EQ(decode_odrive(short_frame(golden.id, golden.data)), OdriveReport{golden.means})
        << golden.source << ": " << golden.data;
}

TEST(OdriveCan, prints_published_frames) {
  EXPECT_EQ(odrive_set_velocity(1, -2.5, 0.25), short_frame(0x02D, "00 00 20 c0 00 00 80 3e")) << "rust";
  const CanFrame request = odrive_request(1, OdriveCommand::EncoderEstimates);
  EXPECT_TRUE(request.is_request) << "rust";
  EXPECT_EQ(request.id, 0x029U);
  EXPECT_EQ(request.length, 8) << "rust";
  EXPECT_EQ(odrive_request(1, static_cast<OdriveCommand>(0x0C)).id, 0x2CU) << "proto";
}

TEST(OdriveCan, prints_settings_as_words) {
  EXPECT_EQ(odrive_set_axis_state(3, 8), short_frame(0x067, "08 00 00 00"));
  EXPECT_EQ(odrive_set_modes(0, 2, 1), short_frame(0x00B, "02 00 00 00 01 00 00 00"));
  EXPECT_EQ(odrive_clear_errors(62), short_frame(0x7D8, "00"));
  EXPECT_EQ(odrive_set_velocity(0, 0.0), short_frame(0x00D, "00 00 00 00 00 00 00 00")) << "the stop";
}

TEST(OdriveCan, reads_estimates_and_voltage_as_ieee_754) {
  // 1.5 is 3fc00000, -0.25 is be800000, 24 is 41c00000 (IEEE 754 binary32).
  EXPECT_EQ(decode_odrive(short_frame(0x069, "00 00 c0 3f 00 00 80 be")), OdriveReport{(OdriveMotion{3, 1.5, -0.25})});
  EXPECT_EQ(decode_odrive(short_frame(0x017, "00 00 c0 41 00 00 00 00")), OdriveReport{(OdriveVoltage{0, 24.0})});
}

TEST(OdriveCan, takes_no_report_for_what_is_none) {
  EXPECT_EQ(decode_odrive(short_frame(0x009, "00 00 c0 7f 00 00 00 00")), std::nullopt) << "NaN";
  EXPECT_EQ(decode_odrive(short_frame(0x009, "00 00 00 00 00 00 80 7f")), std::nullopt) << "infinite";
  EXPECT_EQ(decode_odrive(short_frame(0x017, "00 00 80 ff")), std::nullopt) << "infinite";
  EXPECT_EQ(decode_odrive(short_frame(0x001, "00 00 00 00")), std::nullopt) << "no state";
  EXPECT_EQ(decode_odrive(short_frame(0x009, "00 00 c0 3f")), std::nullopt) << "no velocity";
  EXPECT_EQ(decode_odrive(short_frame(0x00D, "00 00 00 00 00 00 00 00")), std::nullopt) << "another host's command";
  EXPECT_EQ(decode_odrive(odrive_request(0, OdriveCommand::EncoderEstimates)), std::nullopt) << "a request";
  CanFrame extended = short_frame(0x001, "00 00 00 00 08 00 00 00");
  extended.is_extended = true;
  EXPECT_EQ(decode_odrive(extended), std::nullopt) << "another protocol's identifier";
}

}  // namespace
}  // namespace nacelle::diff_drive
