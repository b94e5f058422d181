// SPDX-License-Identifier: Apache-2.0
#include "look/component/picture_maker.hpp"

#include <gtest/gtest.h>
#include <jpeglib.h>

#include <cstdio>

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::look {
namespace {

struct Pixels {
  unsigned width = 0, height = 0, channels = 0;
  std::vector<std::uint8_t> bytes;
};

Pixels decoded(const Bytes& cdr) {
  sensor_msgs::msg::CompressedImage message;
  EXPECT_TRUE(msgs::from_cdr(cdr, message));
  EXPECT_EQ(message.format, "jpeg");
  EXPECT_EQ(message.header.frame_id, "camera");
  jpeg_decompress_struct info{};
  jpeg_error_mgr errors{};
  info.err = jpeg_std_error(&errors);
  jpeg_create_decompress(&info);
  jpeg_mem_src(&info, message.data.data(), message.data.size());
  jpeg_read_header(&info, TRUE);
  jpeg_start_decompress(&info);
  Pixels made{info.output_width, info.output_height, static_cast<unsigned>(info.output_components), {}};
  made.bytes.resize(std::size_t{made.width} * made.height * made.channels);
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = &made.bytes[std::size_t{info.output_scanline} * made.width * made.channels];
    jpeg_read_scanlines(&info, &row, 1);
  }
  jpeg_destroy_decompress(&info);
  return made;
}

sensor_msgs::msg::Image image(const std::string& encoding, std::uint32_t width, std::uint32_t height,
                              const std::vector<std::uint8_t>& pixel) {
  sensor_msgs::msg::Image made;
  made.header.frame_id = "camera";
  made.encoding = encoding;
  made.width = width;
  made.height = height;
  made.step = static_cast<std::uint32_t>(width * pixel.size());
  for (std::size_t i = 0; i < std::size_t{width} * height; ++i) {
    for (const std::uint8_t byte : pixel) made.data.push_back(byte);
  }
  return made;
}

TEST(PictureMaker, a_small_picture_keeps_its_size_and_colours) {
  PictureMaker maker;
  const auto made = maker.make(image("rgb8", 64, 48, {200, 100, 50}));
  ASSERT_TRUE(made) << made.error();
  const Pixels pixels = decoded(*made);
  EXPECT_EQ(pixels.width, 64U);
  EXPECT_EQ(pixels.height, 48U);
  ASSERT_EQ(pixels.channels, 3U);
  EXPECT_NEAR(pixels.bytes[0], 200, 4);
  EXPECT_NEAR(pixels.bytes[1], 100, 4);
  EXPECT_NEAR(pixels.bytes[2], 50, 4);
}

TEST(PictureMaker, a_large_picture_is_the_mean_of_its_pixels) {
  PictureMaker maker;
  auto source = image("bgr8", 1280, 720, {0, 0, 0});
  // Columns in turn black and white: the mean is grey.
  for (std::size_t i = 0; i < source.data.size(); ++i) source.data[i] = (i / 3) % 2 == 0 ? 0 : 255;
  const auto made = maker.make(source);
  ASSERT_TRUE(made) << made.error();
  const Pixels pixels = decoded(*made);
  EXPECT_EQ(pixels.width, 640U);
  EXPECT_EQ(pixels.height, 360U);
  for (const std::size_t at : {std::size_t{0}, pixels.bytes.size() / 2, pixels.bytes.size() - 1})
    EXPECT_NEAR(pixels.bytes[at], 128, 2);
}

TEST(PictureMaker, other_encodings_are_shown_in_grey) {
  PictureMaker maker;
  for (const auto& [encoding, pixel] :
       std::initializer_list<std::pair<std::string, std::vector<std::uint8_t>>>{{"mono8", {90}},
                                                                                {"yuv422_yuy2", {90, 128}},
                                                                                {"yuyv", {90, 1}},
                                                                                {"yuv422", {128, 90}},
                                                                                {"uyvy", {255, 90}},
                                                                                {"bayer_rggb8", {90}}}) {
    const auto made = maker.make(image(encoding, 32, 16, pixel));
    ASSERT_TRUE(made) << encoding << ": " << made.error();
    const Pixels pixels = decoded(*made);
    EXPECT_EQ(pixels.channels, 1U) << encoding;
    EXPECT_EQ(pixels.width, encoding.starts_with("bayer") ? 16U : 32U) << encoding;
    EXPECT_NEAR(pixels.bytes[0], 90, 2) << encoding;
  }
}

TEST(PictureMaker, a_picture_that_lies_about_its_size_is_refused) {
  PictureMaker maker;
  auto lying = image("rgb8", 8, 8, {1, 2, 3});
  lying.height = 9;
  EXPECT_FALSE(maker.make(lying));
  EXPECT_FALSE(maker.make(image("32FC1", 2, 2, {0, 0, 0, 0})));
  EXPECT_FALSE(maker.make(image("bayer_rggb8", 1, 1, {1})));
  EXPECT_FALSE(maker.make({}));
}

}  // namespace
}  // namespace nacelle::look
