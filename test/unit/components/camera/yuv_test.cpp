// SPDX-License-Identifier: Apache-2.0
#include "camera/protocol/yuv.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace nacelle::camera {
namespace {

int reference(double value) { return static_cast<int>(std::clamp(std::lround(value), 0L, 255L)); }

TEST(YuvToRgb, is_within_one_step_of_bt601_for_every_colour) {
  // One pair a row; every brightness, and chroma in steps of 5.
  std::vector<std::uint8_t> in, out(6);
  for (int u = 0; u < 256; u += 5) {
    for (int v = 0; v < 256; v += 5) {
      for (int y = 0; y < 256; ++y) {
        const std::uint8_t pair[4] = {static_cast<std::uint8_t>(y), static_cast<std::uint8_t>(u),
                                      static_cast<std::uint8_t>(255 - y), static_cast<std::uint8_t>(v)};
        ASSERT_TRUE(yuv_to_rgb(pair, {2, 1, 4}, YuvOrder::Yuyv, RgbOrder::Rgb, out));
        for (int i = 0; i < 2; ++i) {
          const int luma = i == 0 ? y : 255 - y;
          ASSERT_NEAR(out[3 * i], reference(luma + 1.402 * (v - 128)), 1) << y << ' ' << u << ' ' << v;
          ASSERT_NEAR(out[3 * i + 1], reference(luma - 0.344136 * (u - 128) - 0.714136 * (v - 128)), 1)
              << y << ' ' << u << ' ' << v;
          ASSERT_NEAR(out[3 * i + 2], reference(luma + 1.772 * (u - 128)), 1) << y << ' ' << u << ' ' << v;
        }
      }
    }
  }
}

TEST(YuvToRgb, reads_both_orders_writes_both_orders_and_skips_padding) {
  const std::vector<std::uint8_t> yuyv{10, 20, 30, 40, 0xEE, 0xEE, 50, 60, 70, 80, 0xEE, 0xEE};
  const std::vector<std::uint8_t> uyvy{20, 10, 40, 30, 60, 50, 80, 70};
  std::vector<std::uint8_t> a(12), b(12), c(12);
  ASSERT_TRUE(yuv_to_rgb(yuyv, {2, 2, 6}, YuvOrder::Yuyv, RgbOrder::Rgb, a));
  ASSERT_TRUE(yuv_to_rgb(uyvy, {2, 2, 4}, YuvOrder::Uyvy, RgbOrder::Rgb, b));
  EXPECT_EQ(a, b);
  ASSERT_TRUE(yuv_to_rgb(uyvy, {2, 2, 4}, YuvOrder::Uyvy, RgbOrder::Bgr, c));
  std::vector<std::uint8_t> back(12);
  ASSERT_TRUE(swap_red_blue(c, {2, 2, 6}, back));
  EXPECT_EQ(back, a);
}

TEST(YuvToMono, keeps_the_brightness) {
  const std::vector<std::uint8_t> uyvy{20, 10, 40, 30, 60, 50, 80, 70};
  std::vector<std::uint8_t> out(4);
  ASSERT_TRUE(yuv_to_mono(uyvy, {2, 2, 4}, YuvOrder::Uyvy, out));
  EXPECT_EQ(out, (std::vector<std::uint8_t>{10, 30, 50, 70}));
}

TEST(Nv12, has_the_colours_of_the_same_picture_in_yuyv) {
  // Two lines of two pixels, padded by two bytes: Y Y, Y Y, then U V for all four.
  const std::vector<std::uint8_t> nv12{10, 30, 0xEE, 0xEE, 50, 70, 0xEE, 0xEE, 20, 240, 0xEE, 0xEE};
  const std::vector<std::uint8_t> yuyv{10, 20, 30, 240, 50, 20, 70, 240};
  for (const auto order : {RgbOrder::Rgb, RgbOrder::Bgr}) {
    std::vector<std::uint8_t> ours(12), reference(12);
    ASSERT_TRUE(nv12_to_rgb(nv12, {2, 2, 4}, order, ours));
    ASSERT_TRUE(yuv_to_rgb(yuyv, {2, 2, 4}, YuvOrder::Yuyv, order, reference));
    EXPECT_EQ(ours, reference);
  }
  std::vector<std::uint8_t> mono(4);
  ASSERT_TRUE(nv12_to_mono(nv12, {2, 2, 4}, mono));
  EXPECT_EQ(mono, (std::vector<std::uint8_t>{10, 30, 50, 70}));
}

TEST(Nv12, refuses_shapes_that_do_not_fit) {
  std::vector<std::uint8_t> in(6), out(12);
  EXPECT_TRUE(nv12_to_rgb(in, {2, 2, 2}, RgbOrder::Rgb, out));
  EXPECT_FALSE(nv12_to_rgb(ByteView{in}.first(5), {2, 2, 2}, RgbOrder::Rgb, out));
  EXPECT_FALSE(nv12_to_rgb(in, {2, 2, 2}, RgbOrder::Rgb, ByteSpan{out}.first(11)));
  EXPECT_FALSE(nv12_to_rgb(in, {2, 2, 1}, RgbOrder::Rgb, out));
  EXPECT_FALSE(nv12_to_rgb(in, {1, 2, 2}, RgbOrder::Rgb, out));
  EXPECT_FALSE(nv12_to_rgb(in, {2, 1, 2}, RgbOrder::Rgb, out));
  EXPECT_FALSE(nv12_to_mono(in, {2, 2, 2}, ByteSpan{out}.first(3)));
}

TEST(YuvToRgb, refuses_shapes_that_do_not_fit) {
  std::vector<std::uint8_t> in(8), out(12);
  EXPECT_FALSE(yuv_to_rgb(ByteView{in}.first(7), {2, 2, 4}, YuvOrder::Yuyv, RgbOrder::Rgb, out));
  EXPECT_FALSE(yuv_to_rgb(in, {2, 2, 4}, YuvOrder::Yuyv, RgbOrder::Rgb, ByteSpan{out}.first(11)));
  EXPECT_FALSE(yuv_to_rgb(in, {3, 1, 6}, YuvOrder::Yuyv, RgbOrder::Rgb, out));
  EXPECT_FALSE(yuv_to_rgb(in, {2, 2, 3}, YuvOrder::Yuyv, RgbOrder::Rgb, out));
  EXPECT_FALSE(yuv_to_rgb(in, {0, 2, 4}, YuvOrder::Yuyv, RgbOrder::Rgb, out));
}

}  // namespace
}  // namespace nacelle::camera
