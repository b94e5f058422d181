// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "transport_dds/port/blob_type.hpp"
#include "transport_dds/port/payload.hpp"

namespace nacelle::transport_dds {
namespace {

struct TypeDeleter {
  void operator()(BlobType* type) const { ddsi_sertype_unref(type); }
};
using TypePointer = std::unique_ptr<BlobType, TypeDeleter>;

TypePointer make_type(const BlobLimits& limits = {}) {
  return TypePointer{make_blob_type("std_msgs::msg::dds_::String_", "RIHS01_1", limits)};
}

void give_back(Blob* blob) { const Payload payload{blob}; }

TEST(BlobPool, uses_memory_that_came_back_again) {
  const auto type = make_type();
  Blob* const first = type->pool->borrow(*type, 1000);
  ASSERT_NE(first, nullptr);
  give_back(first);
  Blob* const second = type->pool->borrow(*type, 990);
  EXPECT_EQ(second, first);
  give_back(second);
}

TEST(BlobPool, aligns_the_body_to_eight_bytes) {
  const auto type = make_type();
  for (const std::size_t bytes : {4U, 5U, 1000U, 70000U}) {
    OutgoingPayload payload{type->pool->borrow(*type, bytes)};
    ASSERT_EQ(payload.bytes().size(), bytes);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(payload.bytes().data() + 4) % 8, 0U) << bytes;
  }
}

TEST(BlobPool, does_not_lend_a_long_piece_for_a_short_message) {
  const auto type = make_type();
  Blob* const picture = type->pool->borrow(*type, 1000000);
  give_back(picture);
  Payload text{type->pool->borrow(*type, 20)};
  EXPECT_EQ(text.bytes().size(), 20U);
  Blob* const next_picture = type->pool->borrow(*type, 1000000);
  EXPECT_EQ(next_picture, picture);
  give_back(next_picture);
}

TEST(BlobPool, keeps_about_twice_the_longest_of_late_and_gives_back_the_rest) {
  const auto type = make_type();
  {
    std::vector<Payload> out;
    for (int i = 0; i < 10; ++i) out.emplace_back(type->pool->borrow(*type, 1000000));
    EXPECT_GE(type->pool->bytes_out(), 10000000U);
  }
  EXPECT_EQ(type->pool->bytes_out(), 0U);
  EXPECT_LE(type->pool->bytes_kept(), 2500000U);
  EXPECT_GE(type->pool->bytes_kept(), 1000000U);
  for (int i = 0; i < 100; ++i) Payload{type->pool->borrow(*type, 100)};
  EXPECT_LE(type->pool->bytes_kept(), 65536U) << "long blocks are freed when they are no longer borrowed";
}

TEST(BlobPool, refuses_and_counts_what_is_beyond_its_limits) {
  const auto type = make_type({.most_bytes = 10000, .most_bytes_out = 20000});
  EXPECT_EQ(type->pool->borrow(*type, 10001), nullptr);
  const Payload first{type->pool->borrow(*type, 9000)};
  EXPECT_TRUE(first);
  EXPECT_EQ(type->pool->borrow(*type, 10000), nullptr) << "both together are more than 20000 bytes of memory";
  EXPECT_EQ(type->pool->refused(), 2U);
}

TEST(BlobPool, lives_until_the_last_payload_is_gone) {
  auto type = make_type();
  OutgoingPayload payload{type->pool->borrow(*type, 100)};
  type.reset();
  payload.bytes()[99] = 7;  // the address sanitizer would report it
  EXPECT_EQ(payload.bytes()[99], 7);
}

TEST(BlobType, is_the_same_for_two_of_one_name_and_structure) {
  const auto one = make_type(), same = make_type();
  const TypePointer other{make_blob_type("std_msgs::msg::dds_::String_", "RIHS01_2", {})};
  EXPECT_TRUE(ddsi_sertype_equal(one.get(), same.get()));
  EXPECT_EQ(ddsi_sertype_hash(one.get()), ddsi_sertype_hash(same.get()));
  EXPECT_FALSE(ddsi_sertype_equal(one.get(), other.get()));
}

TEST(BlobType, puts_pieces_together_and_refuses_what_is_not_whole) {
  const auto type = make_type();
  std::array<std::uint8_t, 5> bytes{1, 2, 3, 4, 5};
  const std::array<ddsrt_iovec_t, 2> pieces{{{bytes.data(), 2}, {bytes.data() + 2, 3}}};
  ddsi_serdata* const whole = ddsi_serdata_from_ser_iov(type.get(), SDK_DATA, 2, pieces.data(), 5);
  ASSERT_NE(whole, nullptr);
  const Payload payload{static_cast<Blob*>(whole)};
  EXPECT_EQ(Bytes(payload.bytes().begin(), payload.bytes().end()), (Bytes{1, 2, 3, 4, 5}));
  std::array<std::uint8_t, 4> last{};
  ddsi_serdata_to_ser(whole, 4, 4, last.data());
  EXPECT_EQ(last, (std::array<std::uint8_t, 4>{5, 0, 0, 0})) << "padding is zero";

  EXPECT_EQ(ddsi_serdata_from_ser_iov(type.get(), SDK_DATA, 2, pieces.data(), 6), nullptr);
}

}  // namespace
}  // namespace nacelle::transport_dds
