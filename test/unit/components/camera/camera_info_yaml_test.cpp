// SPDX-License-Identifier: Apache-2.0
#include "camera/protocol/camera_info_yaml.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace nacelle::camera {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// As camera_calibration writes it.
const std::string kFile = R"(image_width: 640
image_height: 480
camera_name: front
camera_matrix:
  rows: 3
  cols: 3
  data: [500.5, 0., 319.5, 0., 501.25, 239.5, 0., 0., 1.]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.1, -2.5e-1, +0.001, .002, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [490, 0, 320, 0, 0, 495, 240, 0, 0, 0, 1, 0]
)";

std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}
std::string fault(const std::string& text) {
  const auto read = parse_camera_info(text, "front.yaml");
  return read ? "accepted" : read.error().text();
}

TEST(CameraInfoYaml, reads_every_field) {
  const auto read = parse_camera_info(
      kFile + "binning_x: 2\nroi:\n  x_offset: 1\n  y_offset: 2\n  height: 3\n  width: 4\n  do_rectify: true\n", "f");
  ASSERT_TRUE(read) << read.error().text();
  const auto& info = read.value().info;
  EXPECT_EQ(read.value().camera_name, "front");
  EXPECT_EQ(info.width, 640U);
  EXPECT_EQ(info.height, 480U);
  EXPECT_THAT(info.k, ElementsAre(500.5, 0, 319.5, 0, 501.25, 239.5, 0, 0, 1));
  EXPECT_THAT(info.d, ElementsAre(0.1, -0.25, 0.001, 0.002, 0));
  EXPECT_EQ(info.p[0], 490);
  EXPECT_EQ(info.p[10], 1);
  EXPECT_EQ(info.distortion_model, "plumb_bob");
  EXPECT_EQ(info.binning_x, 2U);
  EXPECT_EQ(info.roi.width, 4U);
  EXPECT_TRUE(info.roi.do_rectify);
}

TEST(CameraInfoYaml, takes_the_parsers_defaults_for_what_is_missing) {
  const auto read =
      parse_camera_info(with(with(kFile, "camera_name: front\n", ""), "distortion_model: plumb_bob\n", ""), "f");
  ASSERT_TRUE(read);
  EXPECT_EQ(read.value().camera_name, "unknown");
  EXPECT_EQ(read.value().info.distortion_model, "plumb_bob");
}

TEST(CameraInfoYaml, says_what_is_wrong_and_where) {
  EXPECT_THAT(fault(with(kFile, "image_width: 640\n", "")), HasSubstr("no key 'image_width'"));
  EXPECT_THAT(fault(with(kFile, "500.5", "wide")),
              HasSubstr("front.yaml:7: camera_matrix.data is not a finite number: 'wide'"));
  EXPECT_THAT(fault(with(kFile, "500.5", "nan")), HasSubstr("not a finite number"));
  EXPECT_THAT(fault(with(kFile, "500.5, 0.,", "500.5,")), HasSubstr("camera_matrix.data has 8 numbers, not 9"));
  EXPECT_THAT(fault(with(kFile, "cols: 4", "cols: 5")), HasSubstr("projection_matrix.cols is 5, not 4"));
  EXPECT_THAT(fault(with(kFile, "model: plumb_bob", "model: plum_bob")), HasSubstr("did you mean 'plumb_bob'"));
  EXPECT_THAT(fault(with(kFile, "model: plumb_bob", "model: equidistant")),
              HasSubstr("(equidistant) has 5 numbers, not 4"));
  EXPECT_THAT(fault(with(kFile, "640", "-640")), HasSubstr("not a whole number"));
  EXPECT_THAT(fault("[1, 2]"), HasSubstr("instead of a map"));
  EXPECT_THAT(fault(""), HasSubstr("instead of a map"));
  EXPECT_THAT(fault("a: [1"), HasSubstr("front.yaml:"));
}

}  // namespace
}  // namespace nacelle::camera
