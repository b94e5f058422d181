// SPDX-License-Identifier: Apache-2.0
#include "record/model/byte_buffer.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "support/allocation_guard.hpp"

namespace nacelle::record {
namespace {

TEST(ByteBuffer, keeps_what_it_has_when_it_grows) {
  ByteBuffer buffer;
  EXPECT_EQ(buffer.size(), 0U);
  std::string all;
  for (int i = 0; i < 1000; ++i) {
    buffer.append(as_bytes(std::to_string(i)));
    all += std::to_string(i);
  }
  EXPECT_EQ(as_text(std::as_const(buffer).bytes()), all);
  buffer.append({});
  EXPECT_EQ(buffer.size(), all.size());
}

TEST(ByteBuffer, fills_the_same_memory_again) {
  ByteBuffer buffer{8};
  buffer.append(as_bytes("12345678"));
  const std::uint8_t* const memory = buffer.bytes().data();
  const test::AllocationGuard guard;
  buffer.clear();
  const ByteSpan room = buffer.extend(3);
  EXPECT_EQ(room.data(), memory);
  EXPECT_EQ(as_text(room), "123") << "what was there before";
  EXPECT_EQ(buffer.size(), 3U);
  buffer.append(as_bytes("abcde"));
  EXPECT_EQ(as_text(std::as_const(buffer).bytes()), "123abcde");
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace nacelle::record
