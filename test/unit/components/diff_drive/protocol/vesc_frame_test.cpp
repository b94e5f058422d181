// SPDX-License-Identifier: Apache-2.0
// Frames of public sources: "get values" is in many VESC programs; the speed and the duty are those of a public test of another driver's
// encoder (1000 erpm, duty 0.2). The answer is laid out by hand after commands.c, with a CRC of Python's binascii.crc_hqx().
#include "diff_drive/protocol/vesc_frame.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "diff_drive/protocol/big_endian.hpp"

namespace nacelle::diff_drive {
namespace {

Bytes bytes_of(std::string_view text) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(text, bytes)) << text;
  return bytes;
}
constexpr std::string_view kGetValues = "020104408403";
constexpr std::string_view kAnswer = "02 11 32 0002a180 fffffc18 0169 00010000 00 2a 9821 03";

struct Decoded {
  explicit Decoded(const Bytes& bytes) {
    decoder.feed(bytes, [this](const VescValues& values) { all.push_back(values); });
  }
  VescDecoder decoder;
  std::vector<VescValues> all;
};

TEST(VescPrinter, prints_the_frames_of_public_sources) {
  VescPrinter printer{VescPrinter::kOnTheLine, 42};
  EXPECT_EQ(to_hex(printer.speeds(1000, 0)).substr(0, 20), "020508000003e82b5803");
  EXPECT_EQ(to_hex(printer.zero_duties()),
            "02050500000000235703"
            "0207222a05000000009e4803");
}

TEST(VescDecoder, reads_the_selected_values) {
  const Decoded decoded{bytes_of(kAnswer)};
  ASSERT_EQ(decoded.all.size(), 1U);
  EXPECT_EQ(decoded.all[0], (VescValues{42, -1000, 65536, 36.1, 0, 0}));
  EXPECT_EQ(decoded.decoder.stats().lost_bytes, 0U);
}

TEST(VescDecoder, counts_frames_of_other_commands) {
  const Decoded decoded{bytes_of(kGetValues)};
  EXPECT_TRUE(decoded.all.empty());
  EXPECT_EQ(decoded.decoder.stats().other_frames, 1U);
  EXPECT_EQ(decoded.decoder.stats().other_bytes, 6U);
}

TEST(VescDecoder, finds_the_next_frame_behind_noise_a_torn_one_and_a_false_start) {
  Bytes bytes = bytes_of("ff 03 02 05");
  const Bytes answer = bytes_of(kAnswer);
  bytes.insert(bytes.end(), answer.begin(), answer.begin() + 9);
  bytes.insert(bytes.end(), answer.begin(), answer.end());
  const Decoded decoded{bytes};
  ASSERT_EQ(decoded.all.size(), 1U);
  EXPECT_EQ(decoded.all[0].first_byte, 13U);
  EXPECT_EQ(decoded.decoder.stats().lost_bytes, 13U);
}

TEST(VescDecoder, a_flipped_bit_anywhere_loses_the_frame_and_nothing_else) {
  const Bytes answer = bytes_of(kAnswer);
  for (std::size_t bit = 0; bit < answer.size() * 8; ++bit) {
    Bytes bytes = answer;
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
    bytes.insert(bytes.end(), 90, 0);
    bytes.insert(bytes.end(), answer.begin(), answer.end());
    const Decoded decoded{bytes};
    ASSERT_EQ(decoded.all.size(), 1U) << bit;
    const auto& stats = decoded.decoder.stats();
    ASSERT_EQ(stats.bytes, stats.value_bytes + stats.other_bytes + stats.lost_bytes + decoded.decoder.pending()) << bit;
  }
}

TEST(VescDecoder, needs_each_field_it_hands_out) {
  Bytes payload = bytes_of("32 00000180 fffffc18 0169");
  EXPECT_EQ(decode_vesc_values(payload), std::nullopt);
  payload = bytes_of("32 0002a180 fffffc18 0169 00010000 00");
  EXPECT_EQ(decode_vesc_values(payload), std::nullopt);
}

TEST(VescFault, names_the_side) {
  EXPECT_EQ(vesc_fault(0, true), nullptr);
  EXPECT_STREQ(vesc_fault(2, true), "left VESC: voltage too low");
  EXPECT_STREQ(vesc_fault(11, false), "right VESC: encoder (SPI)");
  EXPECT_NE(vesc_fault(255, false), nullptr);
}

}  // namespace
}  // namespace nacelle::diff_drive
