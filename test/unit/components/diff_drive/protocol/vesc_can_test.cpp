// SPDX-License-Identifier: Apache-2.0
// Golden frames whose source is not ours:
//   [doc]    vedderb/bldc, documentation/comm_can.md: 51 A for the VESC 23 is 0x0117, 00 00 C7 38 (the simple commands share its layout)
//   [forum]  vesc-project.com/node/3345, what a user's VESC 4 sent at rest, and how it answered a short buffer of host 3
#include "diff_drive/protocol/vesc_can.hpp"

#include <gtest/gtest.h>

namespace nacelle::diff_drive {
namespace {

CanFrame long_frame(std::uint32_t id, std::string_view hex) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(hex, bytes)) << hex;
  CanFrame frame;
  frame.id = id;
  frame.is_extended = true;
  frame.length = static_cast<std::uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

TEST(VescCan, reads_what_a_vesc_sent) {
  EXPECT_EQ(decode_vesc_can(long_frame(0x00000904, "00 00 00 00 00 00 00 29")), VescReport{(VescSpeed{4, 0})});
  const auto travel = decode_vesc_can(long_frame(0x00001B04, "00 00 00 0C 00 EF 00 00"));
  ASSERT_TRUE(travel);
  EXPECT_EQ(std::get<VescTravel>(*travel).id, 4);
  EXPECT_EQ(std::get<VescTravel>(*travel).tachometer, 12);
  EXPECT_NEAR(std::get<VescTravel>(*travel).voltage_v, 23.9, 1e-9);
  EXPECT_EQ(decode_vesc_can(long_frame(0x00000E04, "00 00 00 00 00 00 00 00")), std::nullopt) << "Ah";
  EXPECT_EQ(decode_vesc_can(long_frame(0x00001004, "00 FD FE 84 00 00 25 1E")), std::nullopt) << "temperatures";
  EXPECT_EQ(decode_vesc_can(long_frame(0x00000703, "04 01 00 49 53 F2")), std::nullopt) << "an answer to host 3";
}

TEST(VescCan, signs_are_twos_complement) {
  EXPECT_EQ(decode_vesc_can(long_frame(0x0000092A, "FF FF FC 18 00 00 00 00")), VescReport{(VescSpeed{42, -1000})});
  EXPECT_EQ(decode_vesc_can(long_frame(0x00001B2A, "FF FF FF F4 00 00 00 00")), VescReport{(VescTravel{42, -12, 0.0})});
}

TEST(VescCan, prints_simple_commands_as_documented) {
  // As the documented one: 0x0117 with 51 * 1000 = 00 00 C7 38.
  EXPECT_EQ(vesc_set_rpm(23, 51000), long_frame(0x0317, "00 00 C7 38"));
  EXPECT_EQ(vesc_set_rpm(23, -51000), long_frame(0x0317, "FF FF 38 C8"));
  EXPECT_EQ(vesc_zero_duty(23), long_frame(0x0017, "00 00 00 00")) << "the stop";
}

TEST(VescCan, asks_for_a_fault_in_a_short_buffer_and_reads_the_answer) {
  // The forum's request was 0804, 03 00 04: who asks, process and answer, the payload.
  EXPECT_EQ(vesc_ask_fault(4), long_frame(0x0804, "FE 00 32 00 00 80 00"));
  EXPECT_EQ(decode_vesc_can(long_frame(0x08FE, "04 01 32 00 00 80 00 02")), VescReport{(VescFaultReport{4, 2})});
  EXPECT_EQ(decode_vesc_can(long_frame(0x0803, "04 01 32 00 00 80 00 02")), std::nullopt) << "to host 3";
  EXPECT_EQ(decode_vesc_can(long_frame(0x08FE, "04 01 32 00 00 81 00 02")), std::nullopt) << "of another mask";
  EXPECT_EQ(decode_vesc_can(long_frame(0x08FE, "04 01 32 00 00 80 00")), std::nullopt) << "too short";
}

TEST(VescCan, takes_no_report_for_what_is_none) {
  EXPECT_EQ(decode_vesc_can(long_frame(0x0904, "00 00 00 00")), std::nullopt) << "too short";
  EXPECT_EQ(decode_vesc_can(long_frame(0x1B04, "00 00 00 00")), std::nullopt) << "no voltage";
  EXPECT_EQ(decode_vesc_can(vesc_set_rpm(4, 1000)), std::nullopt) << "another host's command";
  CanFrame frame = long_frame(0x0104, "00 00 00 00 00 00 00 00");
  frame.is_extended = false;
  EXPECT_EQ(decode_vesc_can(frame), std::nullopt) << "another protocol's identifier";
}

}  // namespace
}  // namespace nacelle::diff_drive
