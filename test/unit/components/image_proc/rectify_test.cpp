// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "image_proc/component/rectify_component.hpp"
#include "image_proc/model/rectification.hpp"
#include "pictures.hpp"
#include "support/recording_host.hpp"

namespace nacelle::image_proc {
namespace {

using sensor_msgs::msg::CameraInfo;
using sensor_msgs::msg::Image;

constexpr std::uint32_t kWidth = 64, kHeight = 48;
constexpr double kFx = 50, kFy = 52, kCx = 31, kCy = 24;

CameraInfo calibration(const char* model, std::initializer_list<double> d) {
  CameraInfo info;
  info.width = kWidth;
  info.height = kHeight;
  info.distortion_model = model;
  info.d = d;
  info.k = {kFx, 0, kCx, 0, kFy, kCy, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {kFx, 0, kCx, 0, 0, kFy, kCy, 0, 0, 0, 1, 0};
  return info;
}

// A linear picture: between pixels its value is that of the formula, too.
double slope(double x, double y, int) { return 5 + 2 * x + 2 * y; }

Image rectified(const CameraInfo& info, const Image& image, Interpolation interpolation = Interpolation::Linear) {
  const auto map = rectification_map(info, interpolation);
  EXPECT_TRUE(map) << to_text(map.error());
  Image made;
  const Picture picture = picture_of(image, plain_encodings()).value();
  set_shape(made, image.width, image.height, picture.encoding);
  map->apply(picture, made.data.data());
  return made;
}

// The forward model as OpenCV's documentation writes it, with powers and quotients in full.
SourcePoint seen_at(const CameraInfo& info, double x, double y) {
  std::array<double, 8> d{};
  std::copy(info.d.begin(), info.d.end(), d.begin());
  const double r = std::hypot(x, y), r2 = r * r, r4 = std::pow(r, 4), r6 = std::pow(r, 6);
  const double radial = (1 + d[0] * r2 + d[1] * r4 + d[4] * r6) / (1 + d[5] * r2 + d[6] * r4 + d[7] * r6);
  const double xd = x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x);
  const double yd = y * radial + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y;
  return {kFx * xd + kCx, kFy * yd + kCy};
}

TEST(Rectification, without_distortion_is_the_image_itself) {
  const Image image = image_of(kWidth, kHeight, "rgb8", 3,
                               [](double x, double y, int c) { return std::fmod(x * 37 + y * 91 + c * 60, 256); });
  for (const char* const model : {"plumb_bob", "rational_polynomial"}) {
    for (const Interpolation interpolation : {Interpolation::Nearest, Interpolation::Linear}) {
      EXPECT_EQ(rectified(calibration(model, {0, 0, 0, 0, 0}), image, interpolation).data, image.data) << model;
      EXPECT_EQ(rectified(calibration(model, {}), image, interpolation).data, image.data) << model;
    }
  }
}

TEST(Rectification, takes_each_pixel_from_where_the_lens_shows_its_ray) {
  const Image image = image_of(kWidth, kHeight, "mono8", 1, slope, 7);
  CameraInfo turned = calibration("plumb_bob", {-0.2, 0.05, 0.002, -0.001, 0.01});
  const double a = 0.1;  // rad, about the y axis: the rectified camera looks to the side
  turned.r = {std::cos(a), 0, -std::sin(a), 0, 1, 0, std::sin(a), 0, std::cos(a)};
  turned.p = {40, 0, 30, -7, 0, 41, 22, 0, 0, 0, 1, 0};  // as of a right camera: P's last column is not part of the map
  for (const CameraInfo& info :
       {calibration("plumb_bob", {-0.3, 0.1, 0.001, -0.002, -0.01}), calibration("plumb_bob", {0.25, 0, 0, 0}),
        calibration("rational_polynomial", {0.2, -0.05, 0.001, 0.001, 0.01, 0.3, 0.02, 0.005}), turned}) {
    const Image made = rectified(info, image);
    int inside = 0, black = 0;
    for (std::uint32_t v = 0; v < kHeight; ++v) {
      for (std::uint32_t u = 0; u < kWidth; ++u) {
        // The ray of the pixel, turned back by the transposed R.
        const double rx = (u - info.p[2]) / info.p[0], ry = (v - info.p[6]) / info.p[5];
        const auto& r = info.r;
        const double x = r[0] * rx + r[3] * ry + r[6], y = r[1] * rx + r[4] * ry + r[7],
                     z = r[2] * rx + r[5] * ry + r[8];
        const SourcePoint from = seen_at(info, x / z, y / z);
        const double margin = std::min({from.x, from.y, kWidth - 1 - from.x, kHeight - 1 - from.y});
        SCOPED_TRACE(::testing::Message() << info.distortion_model << ' ' << info.d[0] << " at " << u << ' ' << v);
        if (margin > 0.01) {
          ASSERT_NEAR(byte_at(made, u, v), slope(from.x, from.y, 0), 0.6);
          ++inside;
        } else if (margin < -0.01) {
          ASSERT_EQ(byte_at(made, u, v), 0);
          ++black;
        }
      }
    }
    EXPECT_GT(inside, 1500) << info.d[0];
    const bool sees_beyond = info.d[0] == 0.25 || info.p[0] == 40;
    EXPECT_GE(black, sees_beyond ? 50 : 0) << info.d[0];
  }
}

TEST(Rectification, of_a_camera_info_without_r_and_p_has_k) {
  const Image image = image_of(kWidth, kHeight, "mono8", 1, slope);
  const CameraInfo whole = calibration("plumb_bob", {-0.3, 0.1, 0.001, -0.002, -0.01});
  CameraInfo short_of = whole;
  short_of.r = {};
  short_of.p = {};
  EXPECT_EQ(rectified(short_of, image).data, rectified(whole, image).data);
}

TEST(Rectification, refuses_what_is_no_calibration) {
  const auto fault = [](auto change) {
    CameraInfo info = calibration("plumb_bob", {0.1, 0, 0, 0, 0});
    change(info);
    const auto map = rectification_map(info, Interpolation::Linear);
    return map ? std::optional<CalibrationFault>{} : std::optional{map.error()};
  };
  EXPECT_EQ(fault([](CameraInfo&) {}), std::nullopt);
  EXPECT_EQ(fault([](CameraInfo& i) { i.k = {}; }), CalibrationFault::Uncalibrated);
  EXPECT_EQ(fault([](CameraInfo& i) { i.distortion_model = "equidistant"; }), CalibrationFault::UnknownModel);
  EXPECT_EQ(fault([](CameraInfo& i) { i.distortion_model.clear(); }), CalibrationFault::UnknownModel);
  EXPECT_EQ(fault([](CameraInfo& i) { i.d.resize(6); }), CalibrationFault::BadNumbers);
  EXPECT_EQ(fault([](CameraInfo& i) { i.d[1] = std::nan(""); }), CalibrationFault::BadNumbers);
  EXPECT_EQ(fault([](CameraInfo& i) { i.k[0] = std::nan(""); }), CalibrationFault::BadNumbers);
  EXPECT_EQ(fault([](CameraInfo& i) { i.p[3] = INFINITY; }), CalibrationFault::BadNumbers);
  EXPECT_EQ(fault([](CameraInfo& i) { i.p[10] = 0; }), CalibrationFault::BadNumbers) << "no inverse";
  EXPECT_EQ(fault([](CameraInfo& i) { i.width = 0; }), CalibrationFault::BadSize);
  EXPECT_EQ(fault([](CameraInfo& i) { i.height = 0xFFFFFFFF; }), CalibrationFault::BadSize);
  EXPECT_EQ(fault([](CameraInfo& i) { i.width = i.height = kMostSide; }), CalibrationFault::BadSize);
}

class RectifyNode : public ::testing::Test {
 protected:
  void start(RectifyComponent& node) {
    ASSERT_TRUE(node.trigger(Transition::Configure).success);
    ASSERT_TRUE(node.trigger(Transition::Activate).success);
    image_.header.frame_id = "camera_optical_frame";
    image_.header.stamp.sec = 7;
  }
  test::RecordingContext context_;
  Image image_ = image_of(kWidth, kHeight, "mono8", 1, slope);
  CameraInfo info_ = calibration("plumb_bob", {-0.3, 0.1, 0, 0, 0});
};

TEST_F(RectifyNode, publishes_the_rectified_image_with_the_images_header) {
  RectifyComponent node{NodeOptions{context_}};
  start(node);
  context_.inject("/camera_info", info_);
  context_.inject("/image", image_);
  const auto made = context_.published<Image>("/image_rect");
  ASSERT_EQ(made.size(), 1U);
  EXPECT_EQ(made[0].header, image_.header);
  EXPECT_EQ(made[0].encoding, "mono8");
  EXPECT_EQ(made[0].step, kWidth);
  EXPECT_EQ(made[0].data, rectified(info_, image_).data);
}

TEST_F(RectifyNode, computes_the_map_once_for_a_lens) {
  RectifyComponent node{NodeOptions{context_}};
  start(node);
  for (int i = 0; i < 5; ++i) {
    info_.header.stamp.sec = i;  // a camera_info comes with each image
    context_.inject("/camera_info", info_);
    context_.inject("/image", image_);
  }
  EXPECT_EQ(node.maps(), 1U);
  info_.d[0] = -0.2;
  context_.inject("/camera_info", info_);
  EXPECT_EQ(node.maps(), 1U) << "not before an image needs it";
  context_.inject("/image", image_);
  EXPECT_EQ(node.maps(), 2U);
  EXPECT_EQ(node.stats().made, 6U);
}

TEST_F(RectifyNode, does_nothing_while_nothing_is_read) {
  context_.leave_unread("/image_rect");
  RectifyComponent node{NodeOptions{context_}};
  start(node);
  context_.inject("/camera_info", info_);
  context_.inject("/image", image_);
  EXPECT_EQ(node.stats().unread, 1U);
  EXPECT_EQ(node.maps(), 0U);
}

TEST_F(RectifyNode, waits_for_a_camera_info_and_leaves_out_what_does_not_fit_it) {
  RectifyComponent node{NodeOptions{context_}};
  start(node);
  context_.inject("/image", image_);
  EXPECT_EQ(node.stats().waiting, 1U);
  info_.width = 32;
  context_.inject("/camera_info", info_);
  context_.inject("/image", image_);
  EXPECT_EQ(node.stats().refused, 1U) << "another size";
  info_.width = kWidth;
  info_.distortion_model = "equidistant";
  context_.inject("/camera_info", info_);
  context_.inject("/image", image_);
  EXPECT_EQ(node.stats().refused, 2U) << "another model";
  image_.encoding = "bayer_rggb8";
  context_.inject("/image", image_);
  EXPECT_EQ(node.stats().refused, 3U) << "a mosaic";
  EXPECT_TRUE(context_.published<Image>("/image_rect").empty());
  const auto& stats = node.stats();
  EXPECT_EQ(stats.images, stats.made + stats.unread + stats.refused + stats.waiting + stats.no_message);
}

}  // namespace
}  // namespace nacelle::image_proc
