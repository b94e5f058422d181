// SPDX-License-Identifier: Apache-2.0
// Golden bytes: added up by hand from the sensitivities that the makers' data sheets state, not from an encoder.
#include "imu/protocol/chip_decoder.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <vector>

#include "imu/protocol/block_decoder.hpp"
#include "imu/protocol/bno055_uart.hpp"
#include "imu/protocol/rvc_decoder.hpp"
#include "simulation/protocol/st_and_bosch_chips.hpp"

namespace nacelle::imu {
namespace {

Bytes hex(std::string_view text) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(text, bytes));
  return bytes;
}

class Readings final : public ReadingSink {
 public:
  void on_reading(const ChipReading& reading) override { all.push_back(reading); }
  std::vector<ChipReading> all;
};

std::vector<ChipReading> feed(ChipDecoder& decoder, BlockTag tag, std::string_view bytes) {
  Readings readings;
  decoder.feed(static_cast<std::uint8_t>(tag), hex(bytes), readings);
  EXPECT_EQ(decoder.stats().bytes, decoder.stats().used_bytes + decoder.stats().skipped_bytes);
  return readings.all;
}

TEST(InvensenseDecoder, reads_records_of_an_mpu_6050) {
  // 1 g on z at 16384 LSB/g, 25 degrees by (25 - 36.53) * 340 = -3920 = f0b0, 100 deg/s about x at 131 LSB/dps = 13100 = 332c
  InvensenseDecoder decoder{false, InvensenseDecoder::Compass::None};
  const auto readings = feed(decoder, BlockTag::Record, "00000000 4000 f0b0 332c 0000 ff7d ff");
  ASSERT_EQ(readings.size(), 1U);
  EXPECT_EQ(readings[0].acceleration, (Counts{0, 0, 16384}));
  EXPECT_EQ(readings[0].temperature, -3920);
  EXPECT_EQ(readings[0].angular_velocity, (Counts{13100, 0, -131}));
  EXPECT_EQ(decoder.stats().skipped_bytes, 1U) << "half a record";
}

TEST(InvensenseDecoder, an_icm_20948_has_its_temperature_last) {
  InvensenseDecoder decoder{true, InvensenseDecoder::Compass::Ak09916};
  const auto readings = feed(decoder, BlockTag::Record, "00010002 0003 0004 0005 0006 0007");
  ASSERT_EQ(readings.size(), 1U);
  EXPECT_EQ(readings[0].angular_velocity, (Counts{4, 5, 6}));
  EXPECT_EQ(readings[0].temperature, 7);
}

TEST(InvensenseDecoder, a_field_goes_with_the_next_reading_once) {
  InvensenseDecoder decoder{false, InvensenseDecoder::Compass::Ak8963};
  feed(decoder, BlockTag::Field, "01 85 00 00 00 e1 fe 10");
  const auto readings = feed(decoder, BlockTag::Record,
                             "0000000000010000000000000000"
                             "0000000000010000000000000000");
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_EQ(readings[0].field, (Counts{133, 0, -287}));
  EXPECT_FALSE(readings[1].field);
}

TEST(InvensenseDecoder, a_field_that_is_old_or_out_of_range_is_none) {
  InvensenseDecoder old{false, InvensenseDecoder::Compass::Ak8963}, far{false, InvensenseDecoder::Compass::Ak8963};
  feed(old, BlockTag::Field, "00 85 00 00 00 e1 fe 10");
  feed(far, BlockTag::Field, "01 85 00 00 00 e1 fe 18");
  for (InvensenseDecoder* const decoder : {&old, &far}) {
    EXPECT_FALSE(feed(*decoder, BlockTag::Record, "0000000000010000000000000000")[0].field);
    EXPECT_EQ(decoder->stats().skipped_bytes, 8U);
  }
}

TEST(Lsm6dsoxDecoder, joins_the_words_of_a_slot_and_reads_its_clock) {
  // Tag = sensor << 3 | slot << 1 | parity. 1 g on z at 0.122 mg: 8197 = 2005; 10 deg/s at 17.5 mdps: 571 = 023b. 104 Hz: 384 or 385 ticks.
  Lsm6dsoxDecoder decoder{true};
  const auto first = feed(decoder, BlockTag::Record, "0a 3b02 0000 0000  12 0000 0000 0520  21 00010000 0000");
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].angular_velocity, (Counts{571, 0, 0}));
  EXPECT_EQ(first[0].acceleration, (Counts{0, 0, 8197}));
  EXPECT_EQ(first[0].ticks, 0U) << "one timestamp is no step";
  // Here the timestamp comes first.
  const auto second = feed(decoder, BlockTag::Record, "24 81020000 0000  0c 3b02 0000 0000  14 0000 0000 0520");
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].ticks, 0x281U - 0x100U);
}

TEST(Lsm6dsoxDecoder, never_joins_sensors_of_two_slots) {
  Lsm6dsoxDecoder decoder{true};
  EXPECT_TRUE(feed(decoder, BlockTag::Record, "0a 010000000000  14 020000000000").empty());
  EXPECT_EQ(feed(decoder, BlockTag::Record, "0c 030000000000").size(), 1U);
}

TEST(Lsm6dsoxDecoder, counts_words_of_other_sensors_as_skipped) {
  Lsm6dsoxDecoder decoder{true};
  EXPECT_TRUE(feed(decoder, BlockTag::Record, "1a 000000000000").empty());
  EXPECT_EQ(decoder.stats().skipped_bytes, 7U);
}

TEST(Bmi088Decoder, reads_frames_of_the_accelerometer_and_joins_them_with_the_gyros) {
  // 1 g at 6 g range: 32768 / 6 = 5461 = 1555; temperature 0x06 0x20: 6 * 8 + 1 = 49 -> 23 + 49 / 8 degrees
  Bmi088Decoder decoder;
  feed(decoder, BlockTag::Temperature, "06 20");
  EXPECT_TRUE(
      feed(decoder, BlockTag::Acceleration, "84 000000005515 44 112233 40 02 48 01 86 010002005415 80 80").empty());
  EXPECT_EQ(decoder.stats().skipped_bytes, 2U) << "past its end the FIFO reads 80";
  const auto readings = feed(decoder, BlockTag::Record, "0a0000000000 0b0000000000");
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_EQ(readings[0].acceleration, (Counts{0, 0, 5461}));
  EXPECT_EQ(readings[0].temperature, 49);
  EXPECT_EQ(readings[1].acceleration, (Counts{1, 2, 5460}));
  EXPECT_EQ(readings[1].angular_velocity, (Counts{11, 0, 0}));
}

TEST(Bmi088Decoder, eleven_bits_of_temperature_have_a_sign) {
  Bmi088Decoder decoder;
  feed(decoder, BlockTag::Temperature, "ff e0");  // 2047 - 2048
  feed(decoder, BlockTag::Direct, "010000000000");
  EXPECT_EQ(feed(decoder, BlockTag::Record, "000000000000")[0].temperature, -1);
}

TEST(Bno055Decoder, reads_a_block_of_all_registers) {
  // From 08: acceleration z 981 (1/100 m/s^2) = 03d5; field x 320 (1/16 uT); gyro z 160 (1/16 deg/s); quaternion w 16384; 25 degrees
  Bno055Decoder decoder;
  const auto readings = feed(decoder, BlockTag::Record,
                             "0000 0000 d503  4001 0000 0000  0000 0000 a000  000000000000  0040 0000 0000 0000"
                             "000000000000 000000000000 19 ff");
  ASSERT_EQ(readings.size(), 1U);
  EXPECT_EQ(readings[0].acceleration, (Counts{0, 0, 981}));
  EXPECT_EQ(readings[0].field, (Counts{320, 0, 0}));
  EXPECT_EQ(readings[0].angular_velocity, (Counts{0, 0, 160}));
  EXPECT_EQ((*readings[0].quaternion)[0], 16384);
  EXPECT_EQ(readings[0].temperature, 25);
}

TEST(Bno055Decoder, zeros_are_no_field_and_no_quaternion) {
  Bno055Decoder decoder;
  Readings readings;
  decoder.feed(1, Bytes(46), readings);
  ASSERT_EQ(readings.all.size(), 1U);
  EXPECT_FALSE(readings.all[0].field);
  EXPECT_FALSE(readings.all[0].quaternion);
}

TEST(EveryChipDecoder, accounts_for_every_byte_of_noise) {
  const unsigned seed = 88;
  std::mt19937 random{seed};
  InvensenseDecoder mpu{false, InvensenseDecoder::Compass::Ak8963}, icm{true, InvensenseDecoder::Compass::Ak09916};
  Lsm6dsoxDecoder lsm{true}, lsm_direct{false};
  Bmi088Decoder bmi;
  Bno055Decoder bno;
  Readings readings;
  for (ChipDecoder* const decoder : std::initializer_list<ChipDecoder*>{&mpu, &icm, &lsm, &lsm_direct, &bmi, &bno}) {
    for (int i = 0; i < 5000; ++i) {
      Bytes block(random() % 60);
      for (auto& byte : block) byte = random() % 3 == 0 ? 0x84 : static_cast<std::uint8_t>(random());
      decoder->feed(static_cast<std::uint8_t>(random() % 7 + (random() % 20 == 0 ? 0x80 : 0)), block, readings);
    }
    const auto& s = decoder->stats();
    EXPECT_EQ(s.bytes, s.used_bytes + s.skipped_bytes) << "seed " << seed;
    EXPECT_GT(s.overflows, 0U);
  }
}

TEST(BlockDecoder, gives_the_same_blocks_for_any_chopping) {
  const unsigned seed = 3;
  std::mt19937 random{seed};
  Bytes stream;
  for (int i = 0; i < 200; ++i) {
    const std::size_t length = random() % 50;
    stream.push_back(static_cast<std::uint8_t>(random()));
    stream.push_back(static_cast<std::uint8_t>(length));
    stream.push_back(0);
    for (std::size_t k = 0; k < length; ++k) stream.push_back(static_cast<std::uint8_t>(random()));
  }
  const auto decode = [&](std::size_t chunk) {
    BlockDecoder decoder;
    std::vector<std::pair<std::uint8_t, Bytes>> blocks;
    for (std::size_t at = 0; at < stream.size(); at += chunk) {
      decoder.feed(
          ByteView{stream}.subspan(at, std::min(chunk, stream.size() - at)),
          [&](std::uint8_t tag, ByteView payload) { blocks.emplace_back(tag, Bytes(payload.begin(), payload.end())); });
    }
    const auto& s = decoder.stats();
    EXPECT_EQ(s.bytes, 3 * s.blocks + s.payload_bytes + s.skipped_bytes + decoder.pending());
    return blocks;
  };
  const auto whole = decode(stream.size());
  EXPECT_EQ(whole.size(), 200U);
  for (const std::size_t chunk : {1U, 2U, 3U, 7U, 64U}) EXPECT_EQ(decode(chunk), whole) << "chunks of " << chunk;
}

TEST(RvcDecoder, reads_the_makers_example) {
  // BNO080 data sheet, page 21: yaw 0.01, pitch -1.10, roll 20.85 degrees; x -371 mg.
  RvcDecoder decoder;
  std::vector<RvcFrame> frames;
  decoder.feed(hex("aa aa de 01 00 92 ff 25 08 8d fe ec ff d1 03 00 00 00 e7"),
               [&](const RvcFrame& frame, std::size_t after) {
                 EXPECT_EQ(after, 0U);
                 frames.push_back(frame);
               });
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0], (RvcFrame{222, {1, -110, 2085}, {-371, -20, 977}}));
}

TEST(RvcDecoder, finds_frames_in_noise_and_accounts_for_every_byte) {
  const unsigned seed = 19;
  std::mt19937 random{seed};
  Bytes stream;
  for (int i = 0; i < 300; ++i) {
    const auto frame = simulation::print_rvc(static_cast<std::uint8_t>(i), {1.0 * i, 2.0, 3.0}, {0.0, 0.0, 1.0});
    stream.insert(stream.end(), frame.begin(), frame.end());
    for (unsigned n = random() % 4; n > 0; --n)
      stream.push_back(random() % 2 == 0 ? 0xAA : static_cast<std::uint8_t>(random()));
  }
  for (const std::size_t chunk : {std::size_t{1}, std::size_t{19}, std::size_t{64}, stream.size()}) {
    RvcDecoder decoder;
    for (std::size_t at = 0; at < stream.size(); at += chunk) {
      decoder.feed(ByteView{stream}.subspan(at, std::min(chunk, stream.size() - at)),
                   [](const RvcFrame&, std::size_t) {});
    }
    const auto& s = decoder.stats();
    EXPECT_EQ(s.bytes, 19 * s.frames + s.skipped_bytes + decoder.pending());
    EXPECT_EQ(s.frames, 300U) << "seed " << seed << ", chunks of " << chunk;
  }
}

TEST(RvcDecoder, a_flipped_bit_never_becomes_a_frame) {
  const Bytes good = hex("aa aa de 01 00 92 ff 25 08 8d fe ec ff d1 03 00 00 00 e7");
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ (1U << bit % 8));
    RvcDecoder decoder;
    decoder.feed(bad, [&](const RvcFrame&, std::size_t) { ADD_FAILURE() << "bit " << bit; });
  }
}

TEST(Bno055Uart, requests_are_those_of_the_data_sheet) {
  // Section 4.7: write aa 00 register length data, read aa 01 register length.
  EXPECT_EQ(to_hex(bno055_write(0x3D, 0x0C)), "aa003d010c");
  EXPECT_EQ(to_hex(bno055_read(0x08, 46)).substr(0, 8), "aa01082e");
}

TEST(Bno055Uart, reads_answers_however_they_are_chopped) {
  const Bytes stream = hex("00 ee01 bb01a0 ee07 bb03010203 bbee 04");
  for (std::size_t chunk = 1; chunk <= stream.size(); ++chunk) {
    Bno055AnswerDecoder decoder;
    std::vector<std::string> answers;
    for (std::size_t at = 0; at < stream.size(); at += chunk) {
      decoder.feed(ByteView{stream}.subspan(at, std::min(chunk, stream.size() - at)), [&](const Bno055Answer& answer) {
        answers.push_back(std::to_string(answer.status) + ":" + to_hex(answer.data));
      });
    }
    EXPECT_EQ(answers, (std::vector<std::string>{"1:", "1:a0", "7:", "1:010203", "4:"})) << "chunks of " << chunk;
    const auto& s = decoder.stats();
    EXPECT_EQ(s.bytes, s.answer_bytes + s.skipped_bytes + decoder.pending());
    EXPECT_EQ(s.skipped_bytes, 2U) << "noise, and bb with an impossible length";
  }
}

}  // namespace
}  // namespace nacelle::imu
