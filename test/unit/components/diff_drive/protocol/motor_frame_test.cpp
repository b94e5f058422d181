// SPDX-License-Identifier: Apache-2.0
// Frames laid out by hand after docs/motor_board_protocol.md, with CRCs of Python's binascii.crc_hqx().
#include "diff_drive/protocol/motor_frame.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace nacelle::diff_drive {
namespace {

Bytes frame_bytes(std::string_view text) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(text, bytes)) << text;
  return bytes;
}
// Counts 1000 and -1000, 1.5 and -2.5 rad/s, 11.8 V, a fault of the right driver.
constexpr std::string_view kState = "a5 81 14 e8030000 18fcffff 0000c03f 000020c0 182e 0400 8a49";

struct DecodedStates {
  explicit DecodedStates(const Bytes& bytes) {
    decoder.feed(bytes, [this](const MotorFrameState& state) { all.push_back(state); });
    const auto& stats = decoder.stats();
    EXPECT_EQ(stats.bytes, stats.state_bytes + stats.other_bytes + stats.lost_bytes + decoder.pending());
  }
  MotorFrameDecoder decoder;
  std::vector<MotorFrameState> all;
};

TEST(MotorFramePrinter, prints_the_frames_of_the_page) {
  MotorFramePrinter printer;
  EXPECT_EQ(to_hex(printer.speeds(1.5F, -2.5F)), "a501080000c03f000020c0374e");
  EXPECT_EQ(to_hex(printer.stop()), "a502006266");
  EXPECT_EQ(to_hex(printer.settings(200, 10)), "a50304c8000a004a9e");
}

TEST(MotorFrameDecoder, reads_a_state) {
  const DecodedStates decoded{frame_bytes(kState)};
  ASSERT_EQ(decoded.all.size(), 1U);
  EXPECT_EQ(decoded.all[0], (MotorFrameState{1000, -1000, 1.5F, -2.5F, 11800, 4, 0}));
  EXPECT_STREQ(motor_frame_fault(decoded.all[0].faults), "motor board: the driver of the right motor");
  EXPECT_EQ(motor_frame_fault(0), nullptr);
}

TEST(MotorFrameDecoder, a_flipped_bit_anywhere_loses_the_frame_and_nothing_else) {
  const Bytes state = frame_bytes(kState);
  for (std::size_t bit = 0; bit < state.size() * 8; ++bit) {
    Bytes bytes = state;
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
    bytes.insert(bytes.end(), 40, 0);
    bytes.insert(bytes.end(), state.begin(), state.end());
    ASSERT_EQ(DecodedStates{bytes}.all.size(), 1U) << bit;
  }
}

TEST(MotorFrameDecoder, refuses_rates_that_are_no_numbers) {
  const DecodedStates decoded{frame_bytes("a5 81 14 e8030000 18fcffff 0000c07f 000020c0 182e 0400 5316")};
  EXPECT_TRUE(decoded.all.empty());
  EXPECT_EQ(decoded.decoder.stats().other_frames, 1U);
}

}  // namespace
}  // namespace nacelle::diff_drive
