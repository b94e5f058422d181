// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <opencv2/core/mat.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "image_proc/component/resize_component.hpp"
#include "image_proc/model/resizer.hpp"
#include "pictures.hpp"
#include "support/allocation_guard.hpp"
#include "support/recording_host.hpp"

namespace nacelle::image_proc {
namespace {

using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::Image;

Image noise(std::uint32_t width, std::uint32_t height) {
  std::mt19937 random{7};
  return image_of(
      width, height, "rgb8", 3, [&](double, double, int) { return random() % 256; }, 5);
}

Image resized(const Image& image, SamplingMap::Size size, Interpolation interpolation) {
  const Picture picture = picture_of(image, plain_encodings()).value();
  Image made;
  set_shape(made, size.width, size.height, picture.encoding);
  Resizer{interpolation}.resize(picture, size, made.data.data());
  return made;
}

TEST(Resizer, agrees_with_opencv_in_every_interpolation) {
  const Image image = noise(64, 48);
  const cv::Mat from(48, 64, CV_8UC3, const_cast<std::uint8_t*>(image.data.data()), image.step);
  for (const auto& [interpolation, flag] : {std::pair{Interpolation::Nearest, cv::INTER_NEAREST},
                                            {Interpolation::Linear, cv::INTER_LINEAR},
                                            {Interpolation::Cubic, cv::INTER_CUBIC},
                                            {Interpolation::Area, cv::INTER_AREA},
                                            {Interpolation::Lanczos4, cv::INTER_LANCZOS4}}) {
    for (const SamplingMap::Size size : {SamplingMap::Size{32, 24}, {16, 48}, {128, 96}, {61, 37}, {1, 1}, {64, 48}}) {
      const Image made = resized(image, size, interpolation);
      cv::Mat expected;
      cv::resize(from, expected, cv::Size(static_cast<int>(size.width), static_cast<int>(size.height)), 0, 0, flag);
      const int tolerance = interpolation == Interpolation::Linear ? 1 : 0;
      for (std::size_t i = 0; i < made.data.size(); ++i)
        ASSERT_NEAR(made.data[i], expected.data[i], tolerance)
            << flag << ' ' << size.width << " x " << size.height << " byte " << i;
    }
  }
}

TEST(Resizer, halves_a_slope_to_the_means_of_its_pixels) {
  const Image image = image_of(40, 20, "mono8", 1, [](double x, double y, int) { return 4 * x + 2 * y; });
  for (const Interpolation interpolation : {Interpolation::Linear, Interpolation::Area}) {
    const Image made = resized(image, {20, 10}, interpolation);
    for (std::uint32_t v = 0; v < 10; ++v) {
      for (std::uint32_t u = 0; u < 20; ++u) ASSERT_EQ(byte_at(made, u, v), 4 * (2 * u + 0.5) + 2 * (2 * v + 0.5));
    }
  }
}

TEST(Resizer, takes_nothing_from_the_heap_once_the_size_is_known) {
  const Image image = noise(64, 48);
  const Picture picture = picture_of(image, plain_encodings()).value();
  for (const Interpolation interpolation : {Interpolation::Nearest, Interpolation::Linear}) {
    Resizer resizer{interpolation};
    std::vector<std::uint8_t> out(std::size_t{3} * 32 * 24);
    resizer.resize(picture, {32, 24}, out.data());
    const test::AllocationGuard guard;
    for (int i = 0; i < 10; ++i) resizer.resize(picture, {32, 24}, out.data());
    EXPECT_EQ(guard.count(), 0U);
  }
}

CameraInfo calibration() {
  CameraInfo info;
  info.width = 64;
  info.height = 48;
  info.distortion_model = "plumb_bob";
  info.d = {-0.3, 0.1, 0.001, -0.002, -0.01};
  info.k = {50, 0.5, 31, 0, 52, 24, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {40, 0, 30, -8, 0, 44, 20, -12, 0, 0, 1, 0};
  info.roi.x_offset = 8;
  info.roi.y_offset = 4;
  info.roi.width = 32;
  info.roi.height = 40;
  return info;
}

TEST(ScaledCameraInfo, has_k_and_p_of_the_new_size) {
  CameraInfo info = calibration();
  scale(info, {64, 48}, {32, 12});
  EXPECT_EQ(info.width, 32U);
  EXPECT_EQ(info.height, 12U);
  EXPECT_EQ(info.k, (std::array<double, 9>{25, 0.25, 15.5, 0, 13, 6, 0, 0, 1}));
  EXPECT_EQ(info.p, (std::array<double, 12>{20, 0, 15, -4, 0, 11, 5, -3, 0, 0, 1, 0}));
  EXPECT_EQ(info.d, calibration().d) << "rays are the same";
  EXPECT_EQ(info.r, calibration().r);
  EXPECT_EQ(info.roi.x_offset, 4U);
  EXPECT_EQ(info.roi.y_offset, 1U);
  EXPECT_EQ(info.roi.width, 16U);
  EXPECT_EQ(info.roi.height, 10U);
}

TEST(ScaledCameraInfo, keeps_any_region_of_interest_within_its_numbers) {
  CameraInfo info = calibration();
  info.roi.width = info.roi.height = 0xFFFFFFFF;
  scale(info, {1, 1}, {kMostSide, 1});
  EXPECT_EQ(info.roi.width, 0xFFFFFFFFU);
  EXPECT_EQ(info.roi.height, 0xFFFFFFFFU);
}

class ResizeNode : public ::testing::Test {
 protected:
  void start(ResizeComponent& node) {
    ASSERT_TRUE(node.trigger(Transition::Configure).success);
    ASSERT_TRUE(node.trigger(Transition::Activate).success);
    image_.header.frame_id = "camera_optical_frame";
    image_.header.stamp.sec = 7;
  }
  test::RecordingContext context_;
  NodeOptions options_{context_};
  Image image_ = noise(64, 48);
};

TEST_F(ResizeNode, publishes_image_and_camera_info_of_the_scaled_size) {
  ResizeComponent node{
      options_.append_parameter_override("scale_width", 0.5).append_parameter_override("scale_height", 0.25)};
  start(node);
  context_.inject("/image/camera_info", calibration());
  context_.inject("/image/image_raw", image_);
  const auto images = context_.published<Image>("/resize/image_raw");
  const auto infos = context_.published<CameraInfo>("/resize/camera_info");
  ASSERT_EQ(images.size(), 1U);
  ASSERT_EQ(infos.size(), 1U);
  EXPECT_EQ(images[0].header, image_.header);
  EXPECT_EQ(images[0].width, 32U);
  EXPECT_EQ(images[0].height, 12U);
  EXPECT_EQ(images[0].step, 96U);
  EXPECT_EQ(images[0].encoding, "rgb8");
  EXPECT_EQ(images[0].data, resized(image_, {32, 12}, Interpolation::Linear).data);
  EXPECT_EQ(infos[0].header, image_.header);
  EXPECT_EQ(infos[0].width, 32U);
  EXPECT_EQ(infos[0].k[0], 25);
}

TEST_F(ResizeNode, takes_pixels_instead_of_a_scale_and_the_images_own_side_for_minus_one) {
  ResizeComponent node{
      options_.append_parameter_override("use_scale", false).append_parameter_override("width", std::int64_t{16})};
  start(node);
  context_.inject("/image/image_raw", image_);
  const auto images = context_.published<Image>("/resize/image_raw");
  ASSERT_EQ(images.size(), 1U) << "also without a camera_info";
  EXPECT_EQ(images[0].width, 16U);
  EXPECT_EQ(images[0].height, 48U);
  EXPECT_TRUE(context_.published<CameraInfo>("/resize/camera_info").empty());
}

TEST_F(ResizeNode, does_nothing_while_nothing_is_read) {
  context_.leave_unread("/resize/image_raw");
  context_.leave_unread("/resize/camera_info");
  ResizeComponent node{options_};
  start(node);
  context_.inject("/image/image_raw", image_);
  EXPECT_EQ(node.stats().unread, 1U);
}

TEST_F(ResizeNode, publishes_the_camera_info_alone_if_it_alone_is_read) {
  context_.leave_unread("/resize/image_raw");
  ResizeComponent node{options_};
  start(node);
  context_.inject("/image/camera_info", calibration());
  context_.inject("/image/image_raw", image_);
  EXPECT_EQ(context_.published<CameraInfo>("/resize/camera_info").size(), 1U);
}

TEST_F(ResizeNode, refuses_sizes_that_cannot_be) {
  {
    ResizeComponent node{NodeOptions{context_}.append_parameter_override("height", std::int64_t{0})};
    const auto outcome = node.trigger(Transition::Configure);
    EXPECT_FALSE(outcome.success);
    EXPECT_NE(outcome.reason.find("an image cannot have 0 pixels"), std::string::npos) << outcome.reason;
  }
  ResizeComponent node{NodeOptions{context_}
                           .append_parameter_override("scale_width", 100.0)
                           .append_parameter_override("scale_height", 100.0)};
  start(node);
  image_ = noise(200, 2);
  context_.inject("/image/image_raw", image_);
  EXPECT_EQ(node.stats().refused, 1U) << "20000 pixels wide";
  image_.step = 3;
  context_.inject("/image/image_raw", image_);
  EXPECT_EQ(node.stats().refused, 2U);
}

}  // namespace
}  // namespace nacelle::image_proc
