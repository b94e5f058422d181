// SPDX-License-Identifier: Apache-2.0
#include "image_proc/model/debayer.hpp"

#include <gtest/gtest.h>

#include <opencv2/core/utility.hpp>

#include "image_proc/component/debayer_component.hpp"
#include "pictures.hpp"
#include "support/allocation_guard.hpp"
#include "support/recording_host.hpp"

namespace nacelle::image_proc {
namespace {

using sensor_msgs::msg::Image;
using Colours = std::function<double(double, double, int)>;  // of red (0), green and blue

// What a sensor behind that filter sees: the four letters of the name are the colours of the first two rows' first two pixels.
Image mosaic_of(std::uint32_t width, std::uint32_t height, const std::string& encoding, const Colours& colours,
                std::uint32_t padding = 0) {
  const std::string letters = encoding.substr(6, 4);
  return image_of(
      width, height, encoding.c_str(), 1,
      [&](double x, double y, int) {
        const char letter = letters[static_cast<std::size_t>(y) % 2 * 2 + static_cast<std::size_t>(x) % 2];
        return colours(x, y, letter == 'r' ? 0 : letter == 'g' ? 1 : 2);
      },
      padding);
}

double flat(double, double, int colour) { return colour == 0 ? 200 : colour == 1 ? 100 : 30; }
// Linear, with even slopes: means of two and of four neighbours are whole numbers.
double ramp(double x, double y, int colour) {
  return colour == 0 ? 10 + 4 * x + 2 * y : colour == 1 ? 200 - 2 * x - 4 * y : 60 + 2 * x + 2 * y;
}
double luma(const Colours& colours, double x, double y) {
  return 0.299 * colours(x, y, 0) + 0.587 * colours(x, y, 1) + 0.114 * colours(x, y, 2);
}

const Encoding& encoding_named(std::string_view name) {
  for (const Encoding& one : plain_encodings()) {
    if (one.name == name) return one;
  }
  throw std::invalid_argument("no such encoding");
}
Image debayered(const Image& mosaic, std::string_view to) {
  Image made;
  set_shape(made, mosaic.width, mosaic.height, encoding_named(to));
  debayer(picture_of(mosaic, mosaic_encodings(), kLeastMosaicSide).value(), encoding_named(to), made.data.data());
  return made;
}

class EveryMosaic : public ::testing::TestWithParam<const char*> {};

TEST_P(EveryMosaic, of_a_flat_colour_is_that_colour_up_to_the_edges) {
  const Image mosaic = mosaic_of(16, 12, GetParam(), flat, 5);
  const Image rgb = debayered(mosaic, "rgb8"), bgr = debayered(mosaic, "bgr8"), mono = debayered(mosaic, "mono8");
  for (std::uint32_t y = 0; y < 12; ++y) {
    for (std::uint32_t x = 0; x < 16; ++x) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        ASSERT_EQ(byte_at(rgb, x, y, c, 3), flat(x, y, static_cast<int>(c))) << x << ' ' << y;
        ASSERT_EQ(byte_at(bgr, x, y, 2 - c, 3), flat(x, y, static_cast<int>(c))) << x << ' ' << y;
      }
      ASSERT_NEAR(byte_at(mono, x, y), luma(flat, x, y), 1.5) << x << ' ' << y;
    }
  }
}

TEST_P(EveryMosaic, of_a_ramp_is_that_ramp_where_each_pixel_has_its_neighbours) {
  const Image mosaic = mosaic_of(20, 16, GetParam(), ramp);
  const Image rgb = debayered(mosaic, "rgb8");
  const Image mono = debayered(mosaic, "mono8");
  for (std::uint32_t y = 1; y < 15; ++y) {
    for (std::uint32_t x = 1; x < 19; ++x) {
      for (std::uint32_t c = 0; c < 3; ++c)
        ASSERT_EQ(byte_at(rgb, x, y, c, 3), ramp(x, y, static_cast<int>(c))) << x << ' ' << y << " colour " << c;
      ASSERT_NEAR(byte_at(mono, x, y), luma(ramp, x, y), 1.5) << x << ' ' << y;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Names, EveryMosaic,
                         ::testing::Values("bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8"));

TEST(Debayer, takes_nothing_from_the_heap) {
  cv::setNumThreads(1);  // as the component does
  const Image mosaic = mosaic_of(640, 480, "bayer_rggb8", flat);
  Image made = debayered(mosaic, "rgb8");  // with OpenCV's own statics
  const test::AllocationGuard guard;
  for (const std::string_view to : {"rgb8", "bgr8", "mono8"}) {
    set_shape(made, 640, 480, encoding_named(to));
    debayer(picture_of(mosaic, mosaic_encodings()).value(), encoding_named(to), made.data.data());
  }
  EXPECT_EQ(guard.count(), 0U);
}

class DebayerNode : public ::testing::Test {
 protected:
  static void start(DebayerComponent& node) {
    ASSERT_TRUE(node.trigger(Transition::Configure).success);
    ASSERT_TRUE(node.trigger(Transition::Activate).success);
  }
  test::RecordingContext context_;
  NodeOptions options_{context_};
  Image mosaic_ = mosaic_of(16, 12, "bayer_grbg8", flat);
};

TEST_F(DebayerNode, publishes_colour_and_grey_with_the_mosaics_header) {
  DebayerComponent node{options_};
  start(node);
  mosaic_.header.frame_id = "camera_optical_frame";
  mosaic_.header.stamp.sec = 7;
  context_.inject("/image_raw", mosaic_);
  const auto colour = context_.published<Image>("/image_color"), mono = context_.published<Image>("/image_mono");
  ASSERT_EQ(colour.size(), 1U);
  ASSERT_EQ(mono.size(), 1U);
  EXPECT_EQ(colour[0].encoding, "bgr8");
  EXPECT_EQ(colour[0].step, 48U);
  EXPECT_EQ(byte_at(colour[0], 3, 3, 0, 3), 30);
  EXPECT_EQ(mono[0].encoding, "mono8");
  EXPECT_EQ(mono[0].data.size(), 16U * 12U);
  EXPECT_EQ(colour[0].header, mosaic_.header);
  EXPECT_EQ(mono[0].header, mosaic_.header);
  EXPECT_EQ(node.stats().made, 1U);
}

TEST_F(DebayerNode, makes_rgb8_if_it_is_told_to) {
  DebayerComponent node{options_.append_parameter_override("color_encoding", std::string{"rgb8"})};
  start(node);
  context_.inject("/image_raw", mosaic_);
  const auto colour = context_.published<Image>("/image_color");
  ASSERT_EQ(colour.size(), 1U);
  EXPECT_EQ(colour[0].encoding, "rgb8");
  EXPECT_EQ(byte_at(colour[0], 3, 3, 0, 3), 200);
}

TEST_F(DebayerNode, makes_only_what_is_read) {
  context_.leave_unread("/image_color");
  DebayerComponent node{options_};
  start(node);
  context_.inject("/image_raw", mosaic_);
  EXPECT_EQ(context_.published<Image>("/image_mono").size(), 1U);
  EXPECT_EQ(node.stats().made, 1U);
}

TEST_F(DebayerNode, does_nothing_while_nothing_is_read) {
  context_.leave_unread("/image_color");
  context_.leave_unread("/image_mono");
  DebayerComponent node{options_};
  start(node);
  mosaic_.encoding = "nonsense";  // it is not even looked at
  context_.inject("/image_raw", mosaic_);
  EXPECT_EQ(node.stats().unread, 1U);
  EXPECT_EQ(node.stats().refused, 0U);
}

TEST_F(DebayerNode, leaves_out_what_is_no_mosaic) {
  DebayerComponent node{options_};
  start(node);
  mosaic_.encoding = "rgb8";
  context_.inject("/image_raw", mosaic_);
  mosaic_.encoding = "bayer_grbg8";
  mosaic_.data.resize(100);
  context_.inject("/image_raw", mosaic_);
  EXPECT_EQ(node.stats().refused, 2U);
  EXPECT_TRUE(context_.published<Image>("/image_color").empty());
}

TEST_F(DebayerNode, names_the_colours_that_it_makes) {
  DebayerComponent node{options_.append_parameter_override("color_encoding", std::string{"mono8"})};
  const auto outcome = node.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_NE(outcome.reason.find("give bgr8 or rgb8"), std::string::npos) << outcome.reason;
}

}  // namespace
}  // namespace nacelle::image_proc
