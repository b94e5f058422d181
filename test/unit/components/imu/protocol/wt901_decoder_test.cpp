// SPDX-License-Identifier: Apache-2.0
#include "imu/protocol/wt901_decoder.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "simulation/protocol/wt901_device.hpp"

namespace nacelle::imu {
namespace {

std::vector<Wt901Frame> decode(Wt901Decoder& decoder, ByteView bytes, std::size_t chunk) {
  std::vector<Wt901Frame> frames;
  while (!bytes.empty()) {
    const auto part = bytes.first(std::min(chunk, bytes.size()));
    decoder.feed(part, [&](const Wt901Frame& frame, std::size_t) { frames.push_back(frame); });
    bytes = bytes.subspan(part.size());
  }
  return frames;
}

void expect_every_byte_accounted_for(const Wt901Decoder& decoder) {
  const auto& s = decoder.stats();
  EXPECT_EQ(s.bytes, 11 * s.frames + s.skipped_bytes + decoder.pending());
}

Bytes bytes_of(std::string_view hex) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(hex, bytes));
  return bytes;
}

TEST(Wt901Decoder, reads_a_frame_that_was_added_up_by_hand) {
  // 1 g on z is 2048 counts; 0x55 + 0x51 + 0x08 + 0x0c + 0x1c = 0xd6
  Wt901Decoder decoder;
  const auto frames = decode(decoder, bytes_of("55 51 00 00 00 00 00 08 0c 1c d6"), 11);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_TRUE(frames[0].is(Wt901Type::Acceleration));
  EXPECT_EQ(frames[0].values, (std::array<std::int16_t, 4>{0, 0, 2048, 7180}));
}

TEST(Wt901Decoder, gives_the_same_frames_for_any_chopping) {
  const unsigned seed = 901;
  std::mt19937 random{seed};
  Bytes stream;
  for (int i = 0; i < 200; ++i) {
    simulation::Wt901Reading reading;
    for (auto& value : reading.angular_velocity_dps) value = static_cast<double>(random() % 4000) - 2000.0;
    const auto frame = print_wt901(static_cast<std::uint8_t>(0x51 + random() % 4), reading);
    stream.insert(stream.end(), frame.begin(), frame.end());
    for (unsigned noise = random() % 3; noise > 0; --noise)
      stream.push_back(static_cast<std::uint8_t>(random() | 0x80U));
  }
  Wt901Decoder whole;
  const auto expected = decode(whole, stream, stream.size());
  EXPECT_EQ(expected.size(), 200U) << "seed " << seed;
  for (const std::size_t chunk : {1U, 2U, 10U, 11U, 12U, 64U}) {
    Wt901Decoder chopped;
    EXPECT_EQ(decode(chopped, stream, chunk), expected) << "chunks of " << chunk;
    EXPECT_EQ(chopped.stats(), whole.stats()) << "chunks of " << chunk;
    expect_every_byte_accounted_for(chopped);
  }
}

TEST(Wt901Decoder, accounts_for_every_byte_of_noise) {
  const unsigned seed = 55;
  std::mt19937 random{seed};
  Wt901Decoder decoder;
  for (int i = 0; i < 100000; ++i) {
    const std::uint32_t draw = random();
    const std::uint8_t byte = draw % 4 == 0 ? 0x55 : draw % 4 == 1 ? 0x51 : static_cast<std::uint8_t>(draw >> 8U);
    decoder.feed({&byte, 1}, [](const Wt901Frame&, std::size_t) {});
  }
  expect_every_byte_accounted_for(decoder);
  EXPECT_GT(decoder.stats().bad_checksums, 0U) << "seed " << seed;
}

TEST(Wt901Decoder, a_flipped_bit_never_becomes_a_frame) {
  const Bytes good = bytes_of("55 51 00 00 00 00 00 08 0c 1c d6");
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ (1U << bit % 8));
    Wt901Decoder decoder;
    EXPECT_TRUE(decode(decoder, bad, bad.size()).empty()) << "bit " << bit;
  }
}

TEST(Wt901Decoder, does_not_join_bytes_from_before_and_after_a_restart) {
  const Bytes good = bytes_of("55 51 00 00 00 00 00 08 0c 1c d6");
  Wt901Decoder decoder;
  decode(decoder, ByteView{good}.first(5), 5);
  decoder.restart();
  EXPECT_TRUE(decode(decoder, ByteView{good}.subspan(5), 6).empty());
  expect_every_byte_accounted_for(decoder);
}

TEST(Wt901Commands, are_the_makers_bytes) {
  EXPECT_EQ(to_hex(unlock_command()), "ffaa6988b5");
  EXPECT_EQ(to_hex(save_command()), "ffaa000000");
  EXPECT_EQ(to_hex(mask_command(0x021E)), "ffaa021e02");
  ASSERT_TRUE(rate_command(100.0));
  EXPECT_EQ(to_hex(*rate_command(100.0)), "ffaa030900");
  EXPECT_EQ(to_hex(*rate_command(0.2)), "ffaa030100");
  EXPECT_EQ(to_hex(*rate_command(200.0)), "ffaa030b00");
  EXPECT_FALSE(rate_command(60.0));
}

TEST(Wt901Commands, the_device_side_obeys_them_only_when_unlocked) {
  simulation::Wt901Registers registers;
  registers.feed(*rate_command(50.0), 0.0);
  EXPECT_EQ(registers.rate_hz(), 100.0);
  EXPECT_EQ(registers.stats().locked, 1U);

  registers.feed(unlock_command(), 1.0);
  registers.feed(*rate_command(50.0), 10.9);
  registers.feed(mask_command(mask_bit(Wt901Type::AngularVelocity)), 11.0);
  EXPECT_EQ(registers.rate_hz(), 50.0);
  EXPECT_EQ(registers.mask(), 4U);

  registers.feed(*rate_command(20.0), 11.1);
  EXPECT_EQ(registers.rate_hz(), 50.0) << "ten seconds are over";
}

}  // namespace
}  // namespace nacelle::imu
