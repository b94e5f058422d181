// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/receive_buffer.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace nacelle {
namespace {

void receive(ReceiveBuffer& buffer, ByteView bytes) {
  while (!bytes.empty()) {
    const ByteSpan room = buffer.room();
    ASSERT_FALSE(room.empty());
    const std::size_t count = std::min(room.size(), bytes.size());
    std::copy_n(bytes.begin(), count, room.begin());
    buffer.filled(count);
    bytes = bytes.subspan(count);
  }
}

TEST(ReceiveBuffer, keeps_what_waits_in_order_while_pieces_are_used) {
  constexpr std::size_t kLongest = 10'000, kPiece = 777;
  ReceiveBuffer buffer(kLongest);
  std::uint8_t written = 0, read = 0;
  for (int round = 0; round < 500; ++round) {
    Bytes piece(kPiece);
    for (auto& byte : piece) byte = written++;
    receive(buffer, piece);
    while (buffer.waiting().size() > 5000) {
      for (const auto byte : buffer.waiting().first(1234)) ASSERT_EQ(byte, read++);
      buffer.use(1234);
    }
  }
  for (const auto byte : buffer.waiting()) ASSERT_EQ(byte, read++);
  EXPECT_EQ(read, written);
}

TEST(ReceiveBuffer, has_room_until_the_longest_piece_waits) {
  for (const std::size_t longest : {1U, 100U, 4096U, 5000U, 100'000U}) {
    ReceiveBuffer buffer(longest);
    receive(buffer, Bytes(longest - 1));
    EXPECT_EQ(buffer.room().size(), 1U) << longest;
    buffer.filled(1);
    EXPECT_EQ(buffer.waiting().size(), longest);
    EXPECT_TRUE(buffer.room().empty());
  }
}

TEST(ReceiveBuffer, clears_on_request) {
  ReceiveBuffer buffer(100);
  receive(buffer, Bytes(60));
  buffer.clear();
  EXPECT_TRUE(buffer.waiting().empty());
  EXPECT_EQ(buffer.room().size(), 100U);
}

}  // namespace
}  // namespace nacelle
