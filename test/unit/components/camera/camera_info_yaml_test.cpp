// SPDX-License-Identifier: Apache-2.0
#include "camera/protocol/camera_info_yaml.hpp"

#include "camera/protocol/calibration_fault.hpp"

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
/// Returns the problem of a text that is refused.
Problem refusal_of(const std::string& text) {
  const auto read = parse_camera_info(text, "front.yaml");
  return read ? Problem{"accepted", "", ""} : read.error();
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

struct BadCalibration {
  std::string text;
  CalibrationFault fault;
  int line;
  const char* value;
};

TEST(CameraInfoYaml, reports_fault_line_and_value) {
  const BadCalibration cases[] = {
      {with(kFile, "image_width: 640\n", ""), CalibrationFault::MissingKey, 1, "image_width"},
      {with(kFile, "500.5", "wide"), CalibrationFault::NotANumber, 7, "wide"},
      {with(kFile, "500.5", "nan"), CalibrationFault::NotANumber, 7, "nan"},
      {with(kFile, "640", "-640"), CalibrationFault::OutOfRange, 1, "-640"},
      {with(kFile, "640", "65536"), CalibrationFault::OutOfRange, 1, "65536"},
      {with(kFile, "640", "6.5"), CalibrationFault::OutOfRange, 1, "6.5"},
      {with(kFile, "500.5, 0.,", "500.5,"), CalibrationFault::WrongShape, 7, "8"},
      {with(kFile, "cols: 4", "cols: 5"), CalibrationFault::WrongShape, 19, "5"},
      {with(kFile, "model: plumb_bob", "model: equidistant"), CalibrationFault::WrongShape, 12, "5"},
      {with(kFile, "model: plumb_bob", "model: plum_bob"), CalibrationFault::UnknownModel, 8, "plum_bob"},
      {"[1, 2]", CalibrationFault::Malformed, 1, ""},
      {"", CalibrationFault::Malformed, 1, ""},
      {"a: [1", CalibrationFault::Malformed, 1, ""},
  };
  for (const auto& bad : cases) {
    const Problem refusal = refusal_of(bad.text);
    EXPECT_EQ(refusal.code.text(), code_text(bad.fault)) << refusal.text();
    EXPECT_EQ(refusal.where, Place("front.yaml", bad.line)) << refusal.text();
    EXPECT_EQ(refusal.value, bad.value) << refusal.text();
  }
}

TEST(CameraInfoYaml, words_each_fault_with_the_place_in_the_file) {
  EXPECT_EQ(refusal_of(with(kFile, "image_width: 640\n", "")).text(),
            "front.yaml:1: no key 'image_width'; see camera_calibration's file format");
  EXPECT_THAT(refusal_of(with(kFile, "500.5", "wide")).what, "camera_matrix.data is not a finite number: 'wide'");
  EXPECT_EQ(refusal_of(with(kFile, "640", "-640")).what, "image_width is -640, not a whole number from 0 to 65535");
  EXPECT_EQ(refusal_of(with(kFile, "cols: 4", "cols: 5")).what, "projection_matrix.cols is 5, not 4");
  EXPECT_EQ(refusal_of(with(kFile, "model: plumb_bob", "model: plum_bob")).text(),
            "front.yaml:8: distortion_model 'plum_bob' is not known; did you mean 'plumb_bob'?");
  EXPECT_THAT(refusal_of("[1, 2]").what, HasSubstr("instead of a map"));
}

}  // namespace
}  // namespace nacelle::camera
