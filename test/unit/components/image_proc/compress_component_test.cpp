// SPDX-License-Identifier: Apache-2.0
#include "image_proc/component/compress_component.hpp"

#include <gtest/gtest.h>

#include "camera/protocol/jpeg_decoder.hpp"
#include "pictures.hpp"
#include "support/recording_host.hpp"

namespace nacelle::image_proc {
namespace {

using sensor_msgs::msg::CompressedImage;
using sensor_msgs::msg::Image;

class CompressNode : public ::testing::Test {
 protected:
  static void start(CompressComponent& node) {
    ASSERT_TRUE(node.trigger(Transition::Configure).success);
    ASSERT_TRUE(node.trigger(Transition::Activate).success);
  }
  static Image image(const char* encoding, std::uint32_t channels) {
    Image made = image_of(32, 24, encoding, channels, [](double x, double y, int c) { return 4 * x + 2 * y + 20 * c; });
    made.header.frame_id = "camera_optical_frame";
    made.header.stamp.sec = 7;
    return made;
  }
  test::RecordingContext context_;
};

TEST_F(CompressNode, publishes_a_jpeg_with_the_format_of_compressed_image_transport) {
  CompressComponent node{NodeOptions{context_}};
  start(node);
  for (const auto& [encoding, channels] : {std::pair{"rgb8", 3U}, {"bgr8", 3U}, {"bgra8", 4U}, {"mono8", 1U}})
    context_.inject("/image_raw", image(encoding, channels));
  const auto made = context_.published<CompressedImage>("/image_raw/compressed");
  ASSERT_EQ(made.size(), 4U);
  EXPECT_EQ(made[0].format, "rgb8; jpeg compressed bgr8");
  EXPECT_EQ(made[1].format, "bgr8; jpeg compressed bgr8");
  EXPECT_EQ(made[2].format, "bgra8; jpeg compressed bgr8");
  EXPECT_EQ(made[3].format, "mono8; jpeg compressed mono8");
  EXPECT_EQ(made[0].header, image("rgb8", 3).header);
  Bytes pixels(std::size_t{3} * 32 * 24);
  camera::JpegDecoder decoder;
  ASSERT_TRUE(decoder.decode({made[0].data.data(), made[0].data.size()}, 32, 24, camera::JpegColours::Rgb, pixels));
  EXPECT_NEAR(pixels[(12 * 32 + 10) * 3 + 2], 40 + 24 + 40, 8);
}

TEST_F(CompressNode, names_its_topic_after_the_remapped_one) {
  NodeOptions options{context_};
  options.remap_rules({{.from = "image_raw", .to = "camera/image_raw"}});
  CompressComponent node{options};
  start(node);
  context_.inject("/camera/image_raw", image("rgb8", 3));
  EXPECT_EQ(context_.published<CompressedImage>("/camera/image_raw/compressed").size(), 1U);
}

TEST_F(CompressNode, does_nothing_while_nothing_is_read) {
  context_.leave_unread("/image_raw/compressed");
  CompressComponent node{NodeOptions{context_}};
  start(node);
  context_.inject("/image_raw", image("rgb8", 3));
  EXPECT_EQ(node.stats().unread, 1U);
  EXPECT_EQ(node.stats().made, 0U);
}

TEST_F(CompressNode, leaves_out_what_it_cannot_read) {
  CompressComponent node{NodeOptions{context_}};
  start(node);
  context_.inject("/image_raw", image("16UC1", 2));
  Image torn = image("rgb8", 3);
  torn.data.resize(torn.data.size() / 2);
  context_.inject("/image_raw", torn);
  torn.height = 0;
  context_.inject("/image_raw", torn);
  EXPECT_EQ(node.stats().refused, 3U);
  EXPECT_TRUE(context_.published<CompressedImage>("/image_raw/compressed").empty());
}

}  // namespace
}  // namespace nacelle::image_proc
