// SPDX-License-Identifier: Apache-2.0
// Frames laid out by hand after ros_robot_controller_sdk, with CRCs of a shift register in Python; the check value of the CRC is the catalogue's.
#include "diff_drive/protocol/hiwonder_frame.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace nacelle::diff_drive {
namespace {

Bytes hiwonder_bytes(std::string_view text) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(text, bytes)) << text;
  return bytes;
}
constexpr std::string_view kBatteryReport = "aa55 00 03 04 f41c 8a";
constexpr std::string_view kImuReport = "aa55 07 18 00000000 00000000 0000803f 00000000 00000000 00000000 90";

struct DecodedReports {
  explicit DecodedReports(const Bytes& bytes) {
    decoder.feed(bytes, [this](const HiwonderReport& report) { all.push_back(report); });
    const auto& stats = decoder.stats();
    EXPECT_EQ(stats.bytes, stats.frame_bytes + stats.lost_bytes + decoder.pending());
  }
  HiwonderDecoder decoder;
  std::vector<HiwonderReport> all;
};

TEST(HiwonderChecksum, has_the_check_value_of_crc8_maxim) {
  EXPECT_EQ(crc8_maxim(as_bytes(std::string_view{"123456789"})), 0xA1);
}

TEST(HiwonderPrinter, prints_the_speeds_of_two_motors_numbered_from_one) {
  HiwonderPrinter printer{1, 2};
  EXPECT_EQ(to_hex(printer.speeds(0.5F, -1.25F)), "aa55030c0102000000003f010000a0bfdd");
  HiwonderPrinter rear{4, 3};
  EXPECT_EQ(to_hex(rear.speeds(0.0F, 0.0F)), "aa55030c0102030000000002000000008c");
}

TEST(HiwonderDecoder, reads_the_battery_and_names_the_other_reports) {
  const DecodedReports decoded{hiwonder_bytes(std::string(kBatteryReport) + std::string(kImuReport))};
  ASSERT_EQ(decoded.all.size(), 2U);
  EXPECT_EQ(decoded.all[0], (HiwonderReport{0, 7412}));
  EXPECT_EQ(decoded.all[1], (HiwonderReport{7, std::nullopt}));
  EXPECT_EQ(decoded.decoder.stats().lost_bytes, 0U);
}

TEST(HiwonderDecoder, reads_a_battery_with_an_alarm_behind_it) {
  const DecodedReports decoded{hiwonder_bytes("aa55 00 04 04 4a2e 01 09")};
  ASSERT_EQ(decoded.all.size(), 1U);
  EXPECT_EQ(decoded.all[0].battery_mv, 11850);
}

TEST(HiwonderDecoder, an_empty_report_is_a_frame_without_a_battery) {
  const DecodedReports decoded{hiwonder_bytes("aa55 00 00 00")};
  ASSERT_EQ(decoded.all.size(), 1U);
  EXPECT_EQ(decoded.all[0].battery_mv, std::nullopt);
}

TEST(HiwonderDecoder, a_flipped_bit_anywhere_loses_the_frame_and_nothing_else) {
  const Bytes battery = hiwonder_bytes(kBatteryReport);
  for (std::size_t bit = 0; bit < battery.size() * 8; ++bit) {
    Bytes bytes = battery;
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
    bytes.insert(bytes.end(), HiwonderDecoder::kMaxData + 5, 0);
    bytes.insert(bytes.end(), battery.begin(), battery.end());
    const DecodedReports decoded{bytes};
    ASSERT_EQ(decoded.all.size(), 1U) << bit;
    ASSERT_EQ(decoded.all[0].battery_mv, 7412) << bit;
  }
}

TEST(HiwonderDecoder, finds_the_frame_behind_a_false_start) {
  const DecodedReports decoded{
      hiwonder_bytes("aa aa55 55 aa55ff41 aa55 00 03 04" + std::string(kBatteryReport) + std::string(kImuReport))};
  ASSERT_EQ(decoded.all.size(), 2U);
  EXPECT_EQ(decoded.all[0].battery_mv, 7412);
}

TEST(HiwonderDecoder, accounts_for_every_byte_of_noise) {
  std::mt19937 random{20261128};
  Bytes noise(20000);
  for (auto& byte : noise) {
    const auto value = random();
    byte = value % 3 == 0 ? 0xAA : value % 3 == 1 ? 0x55 : static_cast<std::uint8_t>(value >> 8);
  }
  DecodedReports decoded{noise};
  EXPECT_GT(decoded.decoder.stats().bad_checksums, 0U);
  decoded.decoder.restart();
  EXPECT_EQ(decoded.decoder.pending(), 0U);
}

}  // namespace
}  // namespace nacelle::diff_drive
