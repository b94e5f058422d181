// SPDX-License-Identifier: Apache-2.0
#include "image_proc/model/picture.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pictures.hpp"

namespace nacelle::image_proc {
namespace {

using sensor_msgs::msg::Image;
using ::testing::HasSubstr;

Image grey(std::uint32_t width, std::uint32_t height, const char* encoding, std::uint32_t channels) {
  return image_of(width, height, encoding, channels, [](double, double, int) { return 128; });
}

TEST(Picture, is_the_messages_own_memory) {
  for (const Encoding& encoding : plain_encodings()) {
    Image image = grey(7, 5, std::string(encoding.name).c_str(), static_cast<std::uint32_t>(encoding.channels));
    const auto picture = picture_of(image, plain_encodings());
    ASSERT_TRUE(picture) << encoding.name;
    EXPECT_EQ(picture->pixels, image.data.data());
    EXPECT_EQ(picture->step, image.step);
    EXPECT_EQ(picture->width, 7U);
    EXPECT_EQ(picture->height, 5U);
    EXPECT_EQ(picture->encoding.channels, encoding.channels);
  }
}

TEST(Picture, needs_no_padding_behind_the_last_row) {
  Image image = image_of(
      7, 5, "rgb8", 3, [](double, double, int) { return 0; }, 11);
  image.data.resize(image.data.size() - 11);
  EXPECT_TRUE(picture_of(image, plain_encodings()));
  image.data.resize(image.data.size() - 1);
  EXPECT_EQ(picture_of(image, plain_encodings()).error(), PictureFault::DataTooShort);
}

TEST(Picture, refuses_sizes_and_steps_that_the_data_does_not_hold) {
  const auto fault = [](auto change, std::uint32_t least_side = 1) {
    Image image = grey(8, 6, "rgb8", 3);
    change(image);
    const auto picture = picture_of(image, plain_encodings(), least_side);
    return picture ? std::optional<PictureFault>{} : std::optional{picture.error()};
  };
  EXPECT_EQ(fault([](Image&) {}), std::nullopt);
  EXPECT_EQ(fault([](Image& i) { i.width = 0; }), PictureFault::BadSize);
  EXPECT_EQ(fault([](Image& i) { i.height = 0; }), PictureFault::BadSize);
  EXPECT_EQ(fault([](Image& i) { i.width = 0xFFFFFFFF; }), PictureFault::BadSize);
  EXPECT_EQ(fault([](Image& i) { i.height = 0xFFFFFFFF; }), PictureFault::BadSize);
  EXPECT_EQ(fault([](Image& i) { i.width = i.height = kMostSide; }), PictureFault::BadSize) << "too many pixels";
  EXPECT_EQ(fault([](Image&) {}, 7), PictureFault::BadSize);
  EXPECT_EQ(fault([](Image& i) { i.step = 23; }), PictureFault::StepTooShort);
  EXPECT_EQ(fault([](Image& i) { i.step = 0; }), PictureFault::StepTooShort);
  EXPECT_EQ(fault([](Image& i) { i.step = 0xFFFFFFFF; }), PictureFault::DataTooShort);
  EXPECT_EQ(fault([](Image& i) { i.height = 7; }), PictureFault::DataTooShort);
  EXPECT_EQ(fault([](Image& i) { i.data.clear(); }), PictureFault::DataTooShort);
  EXPECT_EQ(fault([](Image& i) { i.encoding = "16UC1"; }), PictureFault::UnknownEncoding);
  EXPECT_EQ(fault([](Image& i) { i.encoding.clear(); }), PictureFault::UnknownEncoding);
}

TEST(Picture, faults_say_what_can_be_taken) {
  Image image = grey(8, 6, "rgb8", 3);
  EXPECT_THAT(
      explain(PictureFault::UnknownEncoding, image, mosaic_encodings()),
      HasSubstr("the encoding is 'rgb8'; it must be one of bayer_rggb8, bayer_bggr8, bayer_gbrg8, bayer_grbg8"));
  EXPECT_THAT(explain(PictureFault::BadSize, image, plain_encodings(), 4),
              HasSubstr("8 x 6 pixels; sides must be from 4 to"));
  EXPECT_THAT(explain(PictureFault::StepTooShort, image, plain_encodings()), HasSubstr("24 bytes (step)"));
  EXPECT_THAT(explain(PictureFault::DataTooShort, image, plain_encodings()),
              HasSubstr("144 bytes, too few for 6 rows"));
  image.encoding.assign(100000, 'x');
  EXPECT_LT(explain(PictureFault::UnknownEncoding, image, plain_encodings()).size(), 200U);
}

}  // namespace
}  // namespace nacelle::image_proc
