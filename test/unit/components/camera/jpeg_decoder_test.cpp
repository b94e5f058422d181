// SPDX-License-Identifier: Apache-2.0
#include "camera/protocol/jpeg_decoder.hpp"

#include <gtest/gtest.h>

#include <random>

#include "camera/model/pattern_scene.hpp"
#include "jpeg_picture.hpp"
#include "support/allocation_guard.hpp"

namespace nacelle::camera {
namespace {

constexpr std::uint32_t kWidth = 160, kHeight = 120;

struct JpegDecoderTest : ::testing::Test {
  JpegDecoderTest() {
    scene.render(10, rgb);
    jpeg = encode_jpeg(rgb, kWidth, kHeight);
  }
  Result<void, JpegFault> decode(ByteView bytes) {
    return decoder.decode(bytes, kWidth, kHeight, JpegColours::Rgb, out);
  }
  [[nodiscard]] double mean_error() const {
    double sum = 0;
    for (std::size_t i = 0; i < rgb.size(); ++i) sum += std::abs(rgb[i] - out[i]);
    return sum / static_cast<double>(rgb.size());
  }

  PatternScene scene{kWidth, kHeight, kRgb24};
  Bytes rgb = Bytes(scene.frame_bytes()), out = Bytes(rgb.size());
  Bytes jpeg;
  JpegDecoder decoder;
};

TEST_F(JpegDecoderTest, gives_the_picture_back) {
  ASSERT_TRUE(decode(jpeg));
  EXPECT_LT(mean_error(), 4.0);
}

TEST_F(JpegDecoderTest, needs_no_huffman_tables_in_the_frame) {
  const Bytes bare = without_tables(jpeg, kHuffmanTables);
  ASSERT_LT(bare.size(), jpeg.size() - 300);
  ASSERT_TRUE(decode(bare));
  EXPECT_LT(mean_error(), 4.0);
}

TEST_F(JpegDecoderTest, takes_no_tables_of_the_frame_before) {
  ASSERT_TRUE(decode(jpeg));

  EXPECT_EQ(decode(without_tables(jpeg, kQuantisationTables)).error(), JpegFault::Corrupt);
  ASSERT_TRUE(decode(jpeg));
  EXPECT_LT(mean_error(), 4.0);
}

TEST_F(JpegDecoderTest, writes_the_other_colours_too) {
  Bytes bgr(rgb.size()), mono(std::size_t{kWidth} * kHeight);
  ASSERT_TRUE(decode(jpeg));
  ASSERT_TRUE(decoder.decode(jpeg, kWidth, kHeight, JpegColours::Bgr, bgr));
  ASSERT_TRUE(decoder.decode(jpeg, kWidth, kHeight, JpegColours::Mono, mono));
  for (std::size_t i = 0; i < mono.size(); ++i) {
    ASSERT_EQ(bgr[3 * i], out[3 * i + 2]);
    ASSERT_EQ(bgr[3 * i + 2], out[3 * i]);
    ASSERT_NEAR(mono[i], 0.299 * out[3 * i] + 0.587 * out[3 * i + 1] + 0.114 * out[3 * i + 2], 30);
  }
}

TEST_F(JpegDecoderTest, says_why_it_refuses) {
  Bytes roomy(200000);
  EXPECT_EQ(decoder.decode(jpeg, kWidth + 2, kHeight, JpegColours::Rgb, roomy).error(), JpegFault::WrongSize);
  EXPECT_EQ(decoder.decode(jpeg, kWidth, kHeight, JpegColours::Rgb, ByteSpan{out}.first(out.size() - 1)).error(),
            JpegFault::WrongSize);
  EXPECT_EQ(decode(encode_jpeg(rgb, kWidth, kHeight, true)).error(), JpegFault::Unsupported);
  EXPECT_EQ(decode({}).error(), JpegFault::Corrupt);
  EXPECT_EQ(decode(ByteView{jpeg}.first(100)).error(), JpegFault::Corrupt);
  EXPECT_EQ(decode(ByteView{jpeg}.first(jpeg.size() / 2)).error(), JpegFault::Damaged);
  EXPECT_TRUE(decode(jpeg)) << "a refused frame leaves the decoder fit for the next";
}

TEST_F(JpegDecoderTest, outlives_any_damage) {
  const unsigned seed = 20261121;
  std::mt19937 random{seed};
  int accepted = 0, refused = 0;
  for (int round = 0; round < 3000; ++round) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", round " << round);
    Bytes damaged = jpeg;
    for (unsigned hits = 1 + random() % 8; hits > 0; --hits)
      damaged[random() % damaged.size()] = static_cast<std::uint8_t>(random());
    damaged.resize(1 + random() % damaged.size());
    ++(decode(damaged) ? accepted : refused);
  }
  EXPECT_GT(refused, 2500);
  EXPECT_TRUE(decode(jpeg));
}

TEST_F(JpegDecoderTest, allocates_nothing_once_it_knows_the_size) {
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(decode(jpeg));
  const test::AllocationGuard guard;
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(decode(jpeg));
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace nacelle::camera
