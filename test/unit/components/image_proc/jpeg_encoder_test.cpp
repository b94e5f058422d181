// SPDX-License-Identifier: Apache-2.0
#include "image_proc/model/jpeg_encoder.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "camera/protocol/jpeg_decoder.hpp"
#include "pictures.hpp"
#include "support/allocation_guard.hpp"

namespace nacelle::image_proc {
namespace {

using camera::JpegColours;
using sensor_msgs::msg::Image;

// Smooth, so that JPEG keeps it.
double scene(double x, double y, int channel) {
  return channel == 3 ? 0 : 128 + 50 * std::sin(x / 9 + channel) + 50 * std::cos(y / 7 - channel);
}
Image scene_in(const std::string& encoding, std::uint32_t channels, std::uint32_t width = 61,
               std::uint32_t height = 35) {
  return image_of(width, height, encoding.c_str(), channels, scene, 3);
}
Picture picture(const Image& image) { return picture_of(image, plain_encodings()).value(); }

Bytes decoded(const Buffer<std::uint8_t>& jpeg, std::uint32_t width, std::uint32_t height, JpegColours to) {
  Bytes pixels(std::size_t{width} * height * (to == JpegColours::Mono ? 1 : 3));
  camera::JpegDecoder decoder;
  const auto outcome = decoder.decode({jpeg.data(), jpeg.size()}, width, height, to, pixels);
  EXPECT_TRUE(outcome) << camera::to_text(outcome.error());
  return pixels;
}

TEST(JpegEncoder, makes_jpegs_that_decode_to_the_picture) {
  JpegEncoder encoder;
  for (const auto& [encoding, channels, colours] : {std::tuple{"rgb8", 3U, JpegColours::Rgb},
                                                    {"bgr8", 3U, JpegColours::Bgr},
                                                    {"rgba8", 4U, JpegColours::Rgb},
                                                    {"bgra8", 4U, JpegColours::Bgr},
                                                    {"mono8", 1U, JpegColours::Mono}}) {
    for (const auto& [width, height] : {std::pair{61U, 35U}, {1U, 1U}, {16U, 16U}, {17U, 8U}}) {
      const Image image = scene_in(encoding, channels, width, height);
      Buffer<std::uint8_t> jpeg;
      ASSERT_TRUE(encoder.encode(picture(image), 95, jpeg)) << encoding;
      const Bytes back = decoded(jpeg, width, height, colours);
      const std::uint32_t kept = std::min(channels, 3U);
      for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
          for (std::uint32_t c = 0; c < kept; ++c) {
            ASSERT_NEAR(back[(std::size_t{y} * width + x) * kept + c], byte_at(image, x, y, c, channels), 16)
                << encoding << ' ' << width << " at " << x << ' ' << y << " channel " << c;
          }
        }
      }
    }
  }
}

TEST(JpegEncoder, writes_fewer_bytes_at_a_lower_quality) {
  JpegEncoder encoder;
  const Image image = scene_in("rgb8", 3, 320, 240);
  Buffer<std::uint8_t> small, large;
  ASSERT_TRUE(encoder.encode(picture(image), 20, small));
  ASSERT_TRUE(encoder.encode(picture(image), 100, large));
  EXPECT_LT(2 * small.size(), large.size());
}

TEST(JpegEncoder, grows_an_output_that_is_too_small) {
  unsigned number = 1;  // noise: its JPEG is larger than the first output
  const Image image = image_of(320, 240, "mono8", 1,
                               [&](double, double, int) { return (number = number * 1664525U + 1013904223U) >> 24U; });
  JpegEncoder encoder;
  Buffer<std::uint8_t> jpeg;
  ASSERT_TRUE(encoder.encode(picture(image), 95, jpeg));
  EXPECT_GT(jpeg.size(), 40000U);
  const Bytes back = decoded(jpeg, 320, 240, JpegColours::Mono);
  for (std::size_t i = 0; i < back.size(); ++i) ASSERT_NEAR(back[i], image.data[i], 24) << i;
}

TEST(JpegEncoder, takes_nothing_from_the_heap_once_it_has_seen_the_size) {
  JpegEncoder encoder;
  const Image colours = scene_in("rgb8", 3, 320, 240), mono = scene_in("mono8", 1, 320, 240);
  Buffer<std::uint8_t> jpeg;
  for (const Image* const image : {&colours, &mono}) ASSERT_TRUE(encoder.encode(picture(*image), 90, jpeg));
  const test::AllocationGuard guard;
  bool good = true;
  for (int i = 0; i < 10; ++i) {
    for (const Image* const image : {&colours, &mono})
      good = encoder.encode(picture(*image), 90, jpeg).has_value() && good;
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_TRUE(good);
}

TEST(JpegEncoder, refuses_a_mosaic_and_encodes_the_next_picture) {
  JpegEncoder encoder;
  Buffer<std::uint8_t> jpeg;
  const Image mosaic = scene_in("bayer_rggb8", 1), image = scene_in("rgb8", 3);
  EXPECT_EQ(encoder.encode(picture_of(mosaic, mosaic_encodings()).value(), 90, jpeg).error(), EncodeFault::Refused);
  EXPECT_TRUE(encoder.encode(picture(image), 90, jpeg));
}

}  // namespace
}  // namespace nacelle::image_proc
