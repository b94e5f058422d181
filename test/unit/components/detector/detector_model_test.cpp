// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "camera/model/pattern_scene.hpp"
#include "detector/model/disc_detector.hpp"
#include "detector/model/image_view.hpp"
#include "detector/model/lens.hpp"

namespace nacelle::detector {
namespace {

using sensor_msgs::msg::Image;

Image image_of(std::uint32_t width, std::uint32_t height, const char* encoding, std::uint32_t step) {
  Image image;
  image.width = width;
  image.height = height;
  image.encoding = encoding;
  image.step = step;
  image.data.resize(std::size_t{step} * height);
  return image;
}

TEST(ImageView, is_the_messages_own_memory_in_every_encoding) {
  for (const auto& [encoding, bytes, type] :
       {std::tuple{"rgb8", 3U, CV_8UC3}, {"bgr8", 3U, CV_8UC3}, {"mono8", 1U, CV_8UC1}, {"yuyv", 2U, CV_8UC2}}) {
    const Image image = image_of(32, 20, encoding, 32 * bytes + 8);
    const auto view = view_of(image);
    ASSERT_TRUE(view) << encoding;
    EXPECT_EQ(view.value().pixels.data, image.data.data());
    EXPECT_EQ(view.value().pixels.type(), type);
    EXPECT_EQ(view.value().pixels.step, image.step);
    EXPECT_EQ(view.value().pixels.cols, 32);
    EXPECT_EQ(view.value().pixels.rows, 20);
  }
}

TEST(ImageView, refuses_images_that_promise_more_than_they_hold) {
  Image image = image_of(32, 20, "rgb8", 96);
  image.data.resize(96 * 20 - 1);
  EXPECT_EQ(view_of(image).error(), ViewFault::TooShort);
  image = image_of(32, 20, "rgb8", 95);
  EXPECT_EQ(view_of(image).error(), ViewFault::TooShort);
  image = image_of(32, 20, "rgb8", 96);
  image.height = 0xFFFFFFFF;
  EXPECT_EQ(view_of(image).error(), ViewFault::TooShort);
  image.height = 0;
  EXPECT_EQ(view_of(image).error(), ViewFault::TooShort);
  image = image_of(32, 20, "16UC1", 64);
  EXPECT_EQ(view_of(image).error(), ViewFault::UnknownEncoding);
}

// A filled ellipse on grey.
Image ellipse(double u, double v, double half_width, double half_height, const std::uint8_t (&rgb)[3]) {
  Image image = image_of(320, 240, "rgb8", 960);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const double dx = (x - u) / half_width, dy = (y - v) / half_height;
      const bool inside = dx * dx + dy * dy <= 1;
      for (int c = 0; c < 3; ++c) image.data[static_cast<std::size_t>(y * 960 + x * 3 + c)] = inside ? rgb[c] : 128;
    }
  }
  return image;
}
constexpr std::uint8_t kOrange[3] = {255, 120, 0}, kRed[3] = {230, 10, 20};

TEST(DiscDetector, measures_discs_of_any_place_and_size) {
  const unsigned seed = 7;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> radius{12, 60}, share{0, 1};
  for (const int decimation : {1, 2, 3}) {
    DiscSettings settings;
    settings.decimation = decimation;
    DiscDetector detector{settings};
    for (int i = 0; i < 100; ++i) {
      const double r = radius(random), u = r + 8 + share(random) * (303 - 2 * r),
                   v = r + 8 + share(random) * (223 - 2 * r);
      SCOPED_TRACE(::testing::Message() << "seed " << seed << ", decimation " << decimation << ", disc " << u << ' '
                                        << v << ' ' << r);
      const Image image = ellipse(u, v, r, r, kOrange);
      const auto& found = detector.find(view_of(image).value());
      ASSERT_EQ(found.size(), 1U);
      ASSERT_NEAR(found[0].u_px, u, 0.3 * decimation);
      ASSERT_NEAR(found[0].v_px, v, 0.3 * decimation);
      ASSERT_NEAR(found[0].radius_px, r, 0.2 * decimation);
    }
  }
}

TEST(DiscDetector, leaves_out_what_is_no_disc_of_that_colour_wholly_in_the_picture) {
  DiscDetector detector{{}};
  const auto count = [&](const Image& image) { return detector.find(view_of(image).value()).size(); };
  EXPECT_EQ(count(ellipse(160, 120, 30, 30, kOrange)), 1U);
  EXPECT_EQ(count(ellipse(160, 120, 30, 30, kRed)), 0U) << "another colour";
  EXPECT_EQ(count(ellipse(160, 120, 40, 20, kOrange)), 0U) << "too slim";
  EXPECT_EQ(count(ellipse(160, 120, 5, 5, kOrange)), 0U) << "too small";
  EXPECT_EQ(count(ellipse(10, 120, 30, 30, kOrange)), 0U) << "cut by the edge";
  EXPECT_EQ(count(image_of(320, 240, "rgb8", 960)), 0U) << "nothing there";
}

TEST(DiscDetector, takes_a_range_of_hues_through_red) {
  DiscSettings settings;
  settings.hue_min = 170;
  settings.hue_max = 8;
  DiscDetector detector{settings};
  EXPECT_EQ(detector.find(view_of(ellipse(160, 120, 30, 30, kRed)).value()).size(), 1U);
  EXPECT_EQ(detector.find(view_of(ellipse(160, 120, 30, 30, kOrange)).value()).size(), 0U);
}

TEST(DiscDetector, reads_the_scene_of_the_camera_in_each_encoding) {
  for (const auto& [encoding, format] :
       {std::pair{"rgb8", camera::kRgb24}, {"bgr8", camera::kBgr24}, {"yuyv", camera::kYuyv}}) {
    const camera::PatternScene scene{640, 480, format};
    Image image = image_of(640, 480, encoding, scene.bytes_per_line());
    scene.render(50, {image.data.data(), image.data.size()});
    const Image before = image;
    DiscDetector detector{{}};
    const auto& found = detector.find(view_of(image).value());
    ASSERT_EQ(found.size(), 1U) << encoding;
    const auto disc = camera::PatternScene::disc_position(50);
    const auto lens = scene.pinhole();
    EXPECT_NEAR(found[0].radius_px, lens.focal_px * 0.1 / disc.z_m, 0.5) << encoding;
    EXPECT_NEAR(found[0].u_px, lens.centre_u_px + lens.focal_px * disc.x_m / disc.z_m, 0.6) << encoding;
    EXPECT_EQ(image, before) << "other readers share these bytes";
  }
}

TEST(DiscDetector, sees_brightness_alone_in_mono8) {
  Image image = image_of(320, 240, "mono8", 320);
  const Image colour = ellipse(160, 120, 30, 30, kOrange);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = colour.data[3 * i] == 255 ? 250 : 100;
  DiscSettings settings;
  settings.value_min = 200;
  DiscDetector detector{settings};
  const auto& found = detector.find(view_of(image).value());
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].radius_px, 30, 0.5);
}

sensor_msgs::msg::CameraInfo calibration(const char* model, std::initializer_list<double> d) {
  sensor_msgs::msg::CameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = model;
  info.d = d;
  info.k = {500, 0, 320, 0, 510, 240, 0, 0, 1};
  return info;
}

// The forward models as OpenCV's documentation writes them.
std::pair<double, double> project(const sensor_msgs::msg::CameraInfo& info, double x, double y) {
  std::array<double, 8> d{};
  std::copy(info.d.begin(), info.d.end(), d.begin());
  const double r2 = x * x + y * y;
  double xd, yd;
  if (info.distortion_model == "equidistant") {
    const double r = std::sqrt(r2), t = std::atan(r), t2 = t * t;
    const double td = t * (1 + d[0] * t2 + d[1] * t2 * t2 + d[2] * t2 * t2 * t2 + d[3] * t2 * t2 * t2 * t2);
    xd = r < 1e-12 ? x : x * td / r;
    yd = r < 1e-12 ? y : y * td / r;
  } else {
    const double radial =
        (1 + d[0] * r2 + d[1] * r2 * r2 + d[4] * r2 * r2 * r2) / (1 + d[5] * r2 + d[6] * r2 * r2 + d[7] * r2 * r2 * r2);
    xd = x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x);
    yd = y * radial + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y;
  }
  return {500 * xd + 320, 510 * yd + 240};
}

TEST(LensLaws, undoing_the_distortion_gives_the_direction_back) {
  for (const auto& info :
       {calibration("plumb_bob", {0, 0, 0, 0, 0}), calibration("plumb_bob", {-0.3, 0.1, 0.001, -0.002, -0.01}),
        calibration("rational_polynomial", {0.2, -0.05, 0.001, 0.001, 0.01, 0.3, 0.02, 0.005}),
        calibration("equidistant", {-0.02, 0.004, -0.001, 0.0002}), calibration("equidistant", {0, 0, 0, 0})}) {
    const auto lens = Lens::from(info);
    ASSERT_TRUE(lens);
    for (double x = -0.6; x <= 0.6; x += 0.1) {
      for (double y = -0.45; y <= 0.45; y += 0.15) {
        const auto [u, v] = project(info, x, y);
        const Direction back = lens->direction_of(u, v);
        ASSERT_NEAR(back.x, x, 1e-4) << info.distortion_model << ' ' << info.d[0] << ' ' << y;
        ASSERT_NEAR(back.y, y, 1e-4) << info.distortion_model << ' ' << info.d[0] << ' ' << x;
      }
    }
  }
}

TEST(Lens, is_none_without_a_calibration) {
  EXPECT_FALSE(Lens::from({}));
  auto broken = calibration("plumb_bob", {0, 0, 0, 0, 0});
  broken.k[0] = std::nan("");
  EXPECT_FALSE(Lens::from(broken));
}

TEST(Lens, assumed_from_an_angle_of_view_looks_to_its_edges) {
  const Lens lens = Lens::assumed(640, 480, 1.0);
  EXPECT_NEAR(lens.direction_of(319.5, 239.5).x, 0, 1e-12);
  EXPECT_NEAR(std::atan(lens.direction_of(639.5, 239.5).x), 0.5, 1e-12);
}

}  // namespace
}  // namespace nacelle::detector
