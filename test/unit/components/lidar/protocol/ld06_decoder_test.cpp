// SPDX-License-Identifier: Apache-2.0
#include "lidar/protocol/ld06_decoder.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "simulation/protocol/ld06_encoder.hpp"

namespace nacelle::lidar {
namespace {

// The packet that the maker's description takes apart (product page of the LD06, inno-maker.com); its checksum is
// right.
constexpr const char* kMakersExample =
    "542c6808ab7ee000e4dc00e2d900e5d500e3d300e4d000e9cd00e4ca00e2c700e9c500e5c200e5c000e5be823a1a50";

Bytes random_packet(std::mt19937& random) {
  simulation::Ld06Packet packet;
  packet.speed_dps = static_cast<std::uint16_t>(1800 + random() % 3000);
  packet.start_cdeg = static_cast<std::uint16_t>(random() % 36000);
  packet.end_cdeg = static_cast<std::uint16_t>((packet.start_cdeg + 880) % 36000);
  if (packet.speed_dps < 2300) packet.end_cdeg = packet.start_cdeg;
  packet.time_ms = static_cast<std::uint16_t>(random() % 30000);
  for (auto& point : packet.points) {
    point = {static_cast<std::uint16_t>(random()), static_cast<std::uint8_t>(random())};
  }
  const auto bytes = print_ld06(packet);
  return {bytes.begin(), bytes.end()};
}

Bytes one_packet() {
  std::mt19937 random{1};
  return random_packet(random);
}

std::vector<Ld06Frame> decode(Ld06Decoder& decoder, ByteView bytes, std::size_t chunk) {
  std::vector<Ld06Frame> frames;
  while (!bytes.empty()) {
    const auto part = bytes.first(std::min(chunk, bytes.size()));
    decoder.feed(part, [&](const Ld06Frame& frame, std::size_t) { frames.push_back(frame); });
    bytes = bytes.subspan(part.size());
  }
  return frames;
}

void expect_every_byte_accounted_for(const Ld06Decoder& decoder) {
  const auto& s = decoder.stats();
  EXPECT_EQ(s.bytes, 47 * (s.frames + s.implausible) + s.skipped_bytes + decoder.pending());
}

TEST(Ld06Crc, knows_the_makers_table) {
  // First and last values of CrcTable in lipkg.cpp: the checksum of one byte is the table's entry.
  EXPECT_EQ(ld06_crc8(Bytes{0}), 0x00);
  EXPECT_EQ(ld06_crc8(Bytes{1}), 0x4d);
  EXPECT_EQ(ld06_crc8(Bytes{2}), 0x9a);
  EXPECT_EQ(ld06_crc8(Bytes{3}), 0xd7);
  EXPECT_EQ(ld06_crc8(Bytes{4}), 0x79);
  EXPECT_EQ(ld06_crc8(Bytes{0xff}), 0xa8);
}

TEST(Ld06Decoder, agrees_with_the_makers_example_and_drops_it_as_the_makers_driver_does) {
  // The example spans 10.43 deg at 2152 deg/s, more than the maker's own plausibility check lets through.
  Bytes packet;
  ASSERT_TRUE(from_hex(kMakersExample, packet));
  EXPECT_EQ(ld06_crc8(ByteView{packet}.first(46)), packet[46]);
  EXPECT_EQ(decode_ld06_frame(packet).error(), Ld06Fault::ImplausibleSpan);

  // The same measurement at a plausible speed, with the checksum made anew.
  packet[4 - 2] = 0x10;
  packet[5 - 2] = 0x0e;  // 3600 deg/s
  packet[46] = ld06_crc8(ByteView{packet}.first(46));
  const auto frame = decode_ld06_frame(packet);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->speed_dps, 3600);
  EXPECT_EQ(frame->first_angle_cdeg, 32427);
  EXPECT_EQ(frame->last_angle_cdeg, 33470);
  EXPECT_EQ(frame->device_time_ms, 6714);
  EXPECT_EQ(frame->points[0], (Ld06Point{224, 228}));
  EXPECT_EQ(frame->points[11], (Ld06Point{192, 229}));
}

TEST(Ld06Decoder, gives_the_same_frames_for_any_chopping) {
  const unsigned seed = 6;
  std::mt19937 random{seed};
  Bytes stream;
  for (int i = 0; i < 50; ++i) {
    const Bytes packet = random_packet(random);
    stream.insert(stream.end(), packet.begin(), packet.end());
    for (unsigned noise = random() % 5; noise > 0; --noise) stream.push_back(static_cast<std::uint8_t>(random()));
  }
  Ld06Decoder whole;
  const auto expected = decode(whole, stream, stream.size());
  EXPECT_EQ(expected.size(), 50U) << "seed " << seed;
  for (const std::size_t chunk : {1U, 2U, 7U, 46U, 47U, 48U, 1000U}) {
    Ld06Decoder chopped;
    EXPECT_EQ(decode(chopped, stream, chunk), expected) << "chunks of " << chunk;
    EXPECT_EQ(chopped.stats(), whole.stats()) << "chunks of " << chunk;
    expect_every_byte_accounted_for(chopped);
  }
}

TEST(Ld06Decoder, reads_back_what_the_device_side_prints) {
  simulation::Ld06Packet packet{3600, 35920, 800, 12345, {}};
  for (std::size_t i = 0; i < packet.points.size(); ++i) {
    packet.points[i] = {static_cast<std::uint16_t>(1000 + i), static_cast<std::uint8_t>(200 + i)};
  }
  const auto bytes = print_ld06(packet);
  Ld06Decoder decoder;
  const auto frames = decode(decoder, bytes, bytes.size());
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].speed_dps, 3600);
  EXPECT_EQ(frames[0].span_cdeg(), 880U);
  EXPECT_DOUBLE_EQ(frames[0].angle_cdeg(0), 35920.0);
  EXPECT_DOUBLE_EQ(frames[0].angle_cdeg(1), 0.0);
  EXPECT_DOUBLE_EQ(frames[0].angle_cdeg(11), 800.0);
  EXPECT_EQ(frames[0].device_time_ms, 12345);
  EXPECT_EQ(frames[0].points[11], (Ld06Point{1011, 211}));
}

TEST(Ld06Decoder, accounts_for_every_byte_of_noise) {
  const unsigned seed = 20261120;
  std::mt19937 random{seed};
  Ld06Decoder decoder;
  for (int i = 0; i < 100000; ++i) {
    // Start bytes are far more frequent than chance has them, so that false starts really happen.
    const std::uint32_t draw = random();
    const std::uint8_t byte = draw % 8 == 0 ? 0x54 : draw % 8 == 1 ? 0x2C : static_cast<std::uint8_t>(draw >> 8U);
    decoder.feed({&byte, 1}, [](const Ld06Frame&, std::size_t) {});
  }
  expect_every_byte_accounted_for(decoder);
  EXPECT_GT(decoder.stats().bad_checksums, 0U) << "seed " << seed;
}

TEST(Ld06Decoder, finds_the_next_frame_after_a_torn_one) {
  const Bytes good = one_packet();
  for (std::size_t torn = 1; torn < good.size(); ++torn) {
    Bytes stream(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(torn));
    stream.insert(stream.end(), good.begin(), good.end());
    Ld06Decoder decoder;
    EXPECT_EQ(decode(decoder, stream, stream.size()).size(), 1U) << torn << " bytes of a torn frame before a whole one";
    expect_every_byte_accounted_for(decoder);
  }
}

TEST(Ld06Decoder, a_flipped_bit_never_becomes_a_frame) {
  const Bytes good = one_packet();
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ (1U << bit % 8));
    Ld06Decoder decoder;
    EXPECT_TRUE(decode(decoder, bad, bad.size()).empty()) << "bit " << bit;
  }
}

TEST(Ld06Decoder, refuses_a_span_that_the_speed_does_not_allow) {
  simulation::Ld06Packet packet{3600, 0, 1441, 0, {}};  // 3600 * 12 / 4500 * 1.5 is 14.40 deg
  Ld06Decoder decoder;
  EXPECT_TRUE(decode(decoder, print_ld06(packet), 47).empty());
  EXPECT_EQ(decoder.stats().implausible, 1U);
  packet.end_cdeg = 1440;
  EXPECT_EQ(decode(decoder, print_ld06(packet), 47).size(), 1U);
  expect_every_byte_accounted_for(decoder);
}

TEST(Ld06Decoder, tells_how_much_of_the_chunk_follows_the_frame) {
  Bytes stream = one_packet();
  stream.insert(stream.end(), 5, 0x00);
  Ld06Decoder decoder;
  std::size_t after = 0;
  decoder.feed(stream, [&](const Ld06Frame&, std::size_t bytes_after) { after = bytes_after; });
  EXPECT_EQ(after, 5U);
}

TEST(Ld06Decoder, does_not_join_bytes_from_before_and_after_a_restart) {
  const Bytes good = one_packet();
  Ld06Decoder decoder;
  const ByteView view{good};
  EXPECT_TRUE(decode(decoder, view.first(20), 20).empty());
  decoder.restart();
  EXPECT_TRUE(decode(decoder, view.subspan(20), 27).empty());
  expect_every_byte_accounted_for(decoder);
}

}  // namespace
}  // namespace nacelle::lidar
