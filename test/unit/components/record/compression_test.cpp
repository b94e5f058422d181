// SPDX-License-Identifier: Apache-2.0
#include "record/protocol/compression.hpp"

#include <gtest/gtest.h>

namespace nacelle::record {
namespace {

class Compressions : public testing::TestWithParam<Compression> {
 protected:
  Compressor compressor_{GetParam()};
  Bytes packed_, again_;
};

TEST_P(Compressions, give_back_what_they_were_given) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{1000}, std::size_t{300000}}) {
    Bytes bytes(size);
    for (std::size_t at = 0; at < size; ++at) bytes[at] = static_cast<std::uint8_t>(at * at >> 7U);
    packed_.clear();
    ASSERT_TRUE(compressor_.append(bytes, packed_)) << size;
    ASSERT_TRUE(uncompress(GetParam(), packed_, size, again_)) << size;
    EXPECT_EQ(again_, bytes);
    EXPECT_FALSE(uncompress(GetParam(), packed_, size + 1, again_)) << "another size";
    if (size > 0) {
      EXPECT_FALSE(uncompress(GetParam(), packed_, size - 1, again_)) << "another size";
      EXPECT_FALSE(uncompress(GetParam(), ByteView{packed_}.first(packed_.size() - 1), size, again_)) << "cut off";
    }
  }
}

TEST_P(Compressions, append_and_have_their_names) {
  packed_ = {1, 2, 3};
  ASSERT_TRUE(compressor_.append(as_bytes("abc"), packed_));
  EXPECT_EQ(packed_[2], 3);
  ASSERT_TRUE(uncompress(GetParam(), ByteView{packed_}.subspan(3), 3, again_));
  EXPECT_EQ(as_text(again_), "abc");
  EXPECT_EQ(compression_of(mcap_name(GetParam())), GetParam());
}

INSTANTIATE_TEST_SUITE_P(All, Compressions, testing::Values(Compression::None, Compression::Lz4, Compression::Zstd));

TEST(Compression, asks_for_no_memory_that_the_bytes_cannot_fill) {
  Bytes out;
  for (const auto compression : {Compression::None, Compression::Lz4, Compression::Zstd})
    EXPECT_FALSE(uncompress(compression, as_bytes("abcd"), std::size_t{1} << 40U, out));
  EXPECT_LT(out.capacity(), 1000U);
  EXPECT_EQ(compression_of("bz2"), std::nullopt);
}

TEST(Crc, is_zlibs) {
  EXPECT_EQ(crc32_of(as_bytes("123456789")), 0xCBF43926U) << "the check value of CRC-32/ISO-HDLC";
  EXPECT_EQ(crc32_of(as_bytes("6789"), crc32_of(as_bytes("12345"))), 0xCBF43926U);
  EXPECT_EQ(crc32_of({}), 0U);
}

}  // namespace
}  // namespace nacelle::record
