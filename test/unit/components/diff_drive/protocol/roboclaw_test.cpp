// SPDX-License-Identifier: Apache-2.0
// Packets laid out by hand after the manual's tables; their CRCs are those of Python's binascii.crc_hqx(), CRC-16/XMODEM.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "diff_drive/protocol/big_endian.hpp"
#include "diff_drive/protocol/roboclaw_answers.hpp"
#include "diff_drive/protocol/roboclaw_packet.hpp"

namespace nacelle::diff_drive {
namespace {

Bytes hex(std::string_view text) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(text, bytes)) << text;
  return bytes;
}

TEST(Crc16Xmodem, has_the_published_check_value) { EXPECT_EQ(crc16_xmodem(as_bytes("123456789")), 0x31C3); }

TEST(RoboclawPrinter, prints_the_packets_of_the_manual) {
  RoboclawPrinter printer{0x80};
  EXPECT_EQ(to_hex(printer.speeds(1000, -1000)), "8025000003e8fffffc188290");
  EXPECT_EQ(to_hex(printer.duties(0, 0)), "8022000000009817");
  EXPECT_EQ(to_hex(RoboclawPrinter{0x87}.duties(32767, -32767)), "87227fff80010217");
  EXPECT_EQ(to_hex(printer.serial_timeout(5)), "800e0548f0");
  EXPECT_EQ(to_hex(printer.read(RoboclawCommand::Encoders)), "804e");
}

/// A decoder that a write has brought into step.
struct InStep {
  InStep() {
    answers.expect(RoboclawCommand::Speed);
    feed("ff");
    heard.clear();
  }
  void feed(std::string_view text) {
    answers.feed(hex(text), [this](const RoboclawAnswer& answer) { heard.push_back(answer); });
  }
  RoboclawAnswers answers{0x80};
  std::vector<RoboclawAnswer> heard;
};

TEST(RoboclawAnswers, reads_each_answer_of_the_manual) {
  InStep line;
  for (const auto command : {RoboclawCommand::SpeedM1, RoboclawCommand::SpeedM2, RoboclawCommand::MainBattery,
                             RoboclawCommand::Encoders, RoboclawCommand::Status, RoboclawCommand::Status}) {
    line.answers.expect(command);
  }
  line.feed("fffffb5001260c");
  line.feed("000004b001ad71");
  line.feed("007bf806");
  line.feed("fffe7960 000111702c82");
  line.feed("00000040cf78");
  line.feed("01007706");

  ASSERT_EQ(line.heard.size(), 6U);
  EXPECT_EQ(line.heard[0].value, -1200);
  EXPECT_EQ(line.heard[1].value, -1200) << "a magnitude and a direction";
  EXPECT_EQ(line.heard[2].value, 123);
  EXPECT_EQ(line.heard[3].value, -100000);
  EXPECT_EQ(line.heard[3].second, 70000);
  EXPECT_EQ(line.heard[4].value, 0x40);
  EXPECT_FALSE(line.heard[4].is_old_layout);
  EXPECT_EQ(line.heard[5].value, 0x100);
  EXPECT_TRUE(line.heard[5].is_old_layout);
  EXPECT_EQ(line.heard[3].first_byte, 1U + 7 + 7 + 4);
  EXPECT_EQ(line.answers.stats().lost_bytes, 0U);
}

TEST(RoboclawAnswers, ignores_all_bytes_until_a_write_is_answered) {
  RoboclawAnswers answers{0x80};
  std::size_t heard = 0;
  const auto count = [&](const RoboclawAnswer&) { ++heard; };
  answers.feed(hex("ff ff 00 01"), count);
  EXPECT_FALSE(answers.is_in_step());
  answers.expect(RoboclawCommand::Speed);
  answers.feed(hex("07 ff"), count);
  EXPECT_FALSE(answers.is_in_step()) << "the answer is not the first byte: more of an earlier one may come";
  answers.expect(RoboclawCommand::Speed);
  answers.feed(hex("ff"), count);
  EXPECT_TRUE(answers.is_in_step());
  EXPECT_EQ(heard, 1U);
  EXPECT_EQ(answers.stats().lost_bytes, 6U);
  EXPECT_EQ(answers.stats().losses, 0U);
}

TEST(RoboclawAnswers, a_flipped_bit_loses_one_answer_and_the_step) {
  InStep line;
  line.answers.expect(RoboclawCommand::Encoders);
  line.feed("fffe7960 000111712c82");
  EXPECT_TRUE(line.heard.empty());
  EXPECT_FALSE(line.answers.is_in_step());
  EXPECT_EQ(line.answers.stats().bad_checksums, 1U);
  EXPECT_EQ(line.answers.stats().losses, 1U);
  EXPECT_EQ(line.answers.stats().lost_bytes, 10U);
}

TEST(RoboclawAnswers, an_answer_to_no_question_loses_the_step) {
  InStep line;
  line.feed("ff");
  EXPECT_FALSE(line.answers.is_in_step());
}

TEST(RoboclawAnswers, accounts_for_random_bytes_in_any_chopping) {
  std::mt19937 random{17};
  for (int round = 0; round < 200; ++round) {
    RoboclawAnswers answers{0x80};
    for (int i = 0; i < 40; ++i) {
      constexpr RoboclawCommand kAll[] = {RoboclawCommand::Speed, RoboclawCommand::Encoders, RoboclawCommand::Status};
      answers.expect(kAll[random() % 3]);
      Bytes bytes(random() % 9);
      for (auto& byte : bytes) byte = random() % 3 == 0 ? 0xFF : static_cast<std::uint8_t>(random());
      answers.feed(bytes, [](const RoboclawAnswer&) {});
      const auto& stats = answers.stats();
      ASSERT_EQ(stats.bytes, stats.answer_bytes + stats.lost_bytes + answers.pending());
    }
  }
}

TEST(RoboclawFault, names_the_gravest_fault_and_no_warning) {
  EXPECT_EQ(roboclaw_fault(0, false), nullptr);
  EXPECT_EQ(roboclaw_fault(0x37F0000, false), nullptr) << "warnings, and S4 and S5";
  EXPECT_STREQ(roboclaw_fault(0x80 | 0x2, false), "RoboClaw: fault of the driver of M2");
  EXPECT_STREQ(roboclaw_fault(0x1 | 0x40, false), "RoboClaw: the emergency stop input is set (E-stop)");
  EXPECT_STREQ(roboclaw_fault(0x4, true), "RoboClaw: the emergency stop input is set (E-stop)");
  EXPECT_EQ(roboclaw_fault(0x3 | 0x3C00, true), nullptr) << "over-current, battery and temperature warnings";
}

}  // namespace
}  // namespace nacelle::diff_drive
