// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/paced_line.hpp"

#include <gtest/gtest.h>

namespace nacelle::simulation {
namespace {

Bytes released(PacedLine& line, Duration now) {
  Bytes all;
  line.release(now, [&](ByteView bytes) { all.insert(all.end(), bytes.begin(), bytes.end()); });
  return all;
}

TEST(PacedLine, a_short_burst_comes_when_its_last_bit_has_left) {
  PacedLine line{100000};  // 100 us a byte
  line.send(1ms, Bytes(10, 7));
  EXPECT_TRUE(released(line, 1999us).empty());
  EXPECT_EQ(released(line, 2ms).size(), 10U);
  EXPECT_TRUE(released(line, 3ms).empty());
}

TEST(PacedLine, a_long_burst_comes_in_chunks_of_a_bridge) {
  PacedLine line{100000};
  line.send(0ms, Bytes(150, 7));
  EXPECT_TRUE(released(line, 6399us).empty());
  EXPECT_EQ(released(line, 6400us).size(), 64U);
  EXPECT_EQ(released(line, 12800us).size(), 64U);
  EXPECT_TRUE(released(line, 14999us).empty());
  EXPECT_EQ(released(line, 15ms).size(), 22U);
}

TEST(PacedLine, never_carries_more_than_its_baud_rate) {
  PacedLine line{115200};
  std::size_t out = 0;
  for (Duration now{}; now <= 1s; now += 1ms) {
    line.send(now, Bytes(20, 7));  // 20000 bytes/s offered
    out += released(line, now).size();
    EXPECT_LE(static_cast<double>(out), to_seconds(now) * 11520 + 1) << to_seconds(now);
  }
  EXPECT_GT(out, 11400U);
  EXPECT_GT(line.lost(), 0U) << "a device's buffer is finite";
}

TEST(PacedLine, keeps_the_order) {
  PacedLine line{1000000};
  Bytes sent, got;
  for (int i = 0; i < 200; ++i) {
    const Bytes piece(static_cast<std::size_t>(1 + i % 30), static_cast<std::uint8_t>(i));
    sent.insert(sent.end(), piece.begin(), piece.end());
    line.send(i * 1ms, piece);
    const Bytes out = released(line, i * 1ms);
    got.insert(got.end(), out.begin(), out.end());
  }
  const Bytes rest = released(line, 1s);
  got.insert(got.end(), rest.begin(), rest.end());
  EXPECT_EQ(got, sent);
}

}  // namespace
}  // namespace nacelle::simulation
