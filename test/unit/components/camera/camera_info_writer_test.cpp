// SPDX-License-Identifier: Apache-2.0
#include "camera/protocol/camera_info_writer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "camera/protocol/calibration_fault.hpp"
#include "camera/protocol/distortion_model.hpp"

namespace nacelle::camera {
namespace {

using sensor_msgs::msg::CameraInfo;
using ::testing::HasSubstr;

CameraInfo calibrated() {
  CameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.d = {0.1, -0.25, 1e-05, 0.002, 0};
  info.k = {500.5, 0, 319.5, 0, 501.25, 239.5, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {490, 0, 320, 0, 0, 495, 240, 0, 0, 0, 1, 0};
  return info;
}

template <typename Numbers>
std::vector<std::uint64_t> bits_of(const Numbers& numbers) {
  std::vector<std::uint64_t> bits;
  for (const double number : numbers) bits.push_back(std::bit_cast<std::uint64_t>(number));
  return bits;
}

/// Reads what was written, and expects the same message.
void expect_round_trip(const Calibration& calibration) {
  const std::string text = camera_info_yaml(calibration);
  SCOPED_TRACE(text);
  const auto read = parse_camera_info(text, "written.yaml");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->camera_name, calibration.camera_name);
  EXPECT_EQ(read->info, calibration.info);
  // Equality of numbers takes 0 for -0.
  EXPECT_EQ(bits_of(read->info.d), bits_of(calibration.info.d));
  EXPECT_EQ(bits_of(read->info.k), bits_of(calibration.info.k));
  EXPECT_EQ(bits_of(read->info.r), bits_of(calibration.info.r));
  EXPECT_EQ(bits_of(read->info.p), bits_of(calibration.info.p));
}

TEST(CameraInfoWriter, writes_the_keys_of_camera_info_manager_and_numbers_with_a_point) {
  EXPECT_EQ(camera_info_yaml({"hd_webcam", calibrated()}), R"(image_width: 640
image_height: 480
camera_name: "hd_webcam"
camera_matrix:
  rows: 3
  cols: 3
  data: [500.5, 0.0, 319.5, 0.0, 501.25, 239.5, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.1, -0.25, 1.0e-05, 0.002, 0.0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
projection_matrix:
  rows: 3
  cols: 4
  data: [490.0, 0.0, 320.0, 0.0, 0.0, 495.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]
)");
}

TEST(CameraInfoWriter, writes_any_accepted_message_so_that_it_reads_back_bit_for_bit) {
  constexpr unsigned kSeed = 20261128;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 random{kSeed};
  const auto any_number = [&] {
    for (;;) {
      const auto number = std::bit_cast<double>(random());
      if (std::isfinite(number)) return number;
    }
  };
  for (int round = 0; round < 300; ++round) {
    CameraInfo info = calibrated();
    const DistortionModel& model = kDistortionModels[static_cast<std::size_t>(round) % kDistortionModels.size()];
    info.distortion_model = std::string{model.name};
    std::vector<double> coefficients(model.coefficients);
    for (double& number : coefficients) number = any_number();
    info.d.assign(coefficients.begin(), coefficients.end());
    for (double& number : info.k) number = any_number();
    for (double& number : info.r) number = any_number();
    for (double& number : info.p) number = any_number();
    if (round % 2 == 0) {
      info.binning_x = static_cast<std::uint32_t>(random() % (kMostBinning + 1));
      info.roi.x_offset = static_cast<std::uint32_t>(random() % (kMostCalibratedPixels + 1));
      info.roi.width = static_cast<std::uint32_t>(random() % (kMostCalibratedPixels + 1));
      info.roi.do_rectify = random() % 2 == 0;
    }
    ASSERT_TRUE(check_camera_info(info, 640, 480));
    ASSERT_NO_FATAL_FAILURE(expect_round_trip({"camera_" + std::to_string(round), info}));
  }
}

TEST(CameraInfoWriter, keeps_the_sign_of_zero_and_the_smallest_and_largest_numbers) {
  CameraInfo info = calibrated();
  using Limits = std::numeric_limits<double>;
  info.k = {-0.0, Limits::denorm_min(), Limits::min(), Limits::max(), Limits::lowest(), 1e22, 1e-7, 0.1, 1.0 / 3};
  expect_round_trip({"front", info});
}

TEST(CameraInfoWriter, keeps_a_camera_name_that_yaml_would_read_as_something_else) {
  for (const char* const name : {"", "true", "~", "0123", "a: b", "# no comment", "quote\" and \\", "line\nbreak\t"})
    expect_round_trip({name, calibrated()});
}

struct Refusal {
  const char* field;
  CalibrationFault fault;
  void (*spoil)(CameraInfo&);
  const char* says;
};
class RefusedCalibration : public ::testing::TestWithParam<Refusal> {};
TEST_P(RefusedCalibration, names_the_field_and_the_value) {
  CameraInfo info = calibrated();
  ASSERT_TRUE(check_camera_info(info, 640, 480));
  GetParam().spoil(info);
  const auto checked = check_camera_info(info, 640, 480);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().where, Place{std::string("camera_info.") + GetParam().field});
  EXPECT_EQ(checked.error().code, GetParam().fault);
  EXPECT_THAT(checked.error().text(), HasSubstr(GetParam().says));
}
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
INSTANTIATE_TEST_SUITE_P(
    All, RefusedCalibration,
    ::testing::Values(
        Refusal{"width", CalibrationFault::WrongSize, [](CameraInfo& sent) { sent.width = 320; },
                "320x480 pixels, the images have 640x480"},
        Refusal{"width", CalibrationFault::WrongSize, [](CameraInfo& sent) { sent.height = 0; }, "640x0 pixels"},
        Refusal{"distortion_model", CalibrationFault::UnknownModel,
                [](CameraInfo& sent) { sent.distortion_model = "plum_bob"; }, "did you mean 'plumb_bob'"},
        Refusal{"distortion_model", CalibrationFault::UnknownModel,
                [](CameraInfo& sent) { sent.distortion_model = std::string(100'000, 'x'); }, "is not known"},
        Refusal{"distortion_model", CalibrationFault::UnknownModel,
                [](CameraInfo& sent) {
                  sent = {};
                  sent.width = 640;
                  sent.height = 480;
                },
                "'' is not known"},
        Refusal{"d", CalibrationFault::WrongShape,
                [](CameraInfo& sent) {
                  sent.d = {1, 2, 3, 4};
                },
                "plumb_bob has 5 coefficients, not 4"},
        Refusal{"d", CalibrationFault::WrongShape,
                [](CameraInfo& sent) { sent.distortion_model = "rational_polynomial"; },
                "rational_polynomial has 8 coefficients, not 5"},
        Refusal{"d", CalibrationFault::NotANumber, [](CameraInfo& sent) { sent.d[4] = kNan; }, "number 4 is nan"},
        Refusal{"k", CalibrationFault::NotANumber, [](CameraInfo& sent) { sent.k[0] = kInfinity; }, "number 0 is inf"},
        Refusal{"r", CalibrationFault::NotANumber, [](CameraInfo& sent) { sent.r[8] = -kInfinity; },
                "number 8 is -inf"},
        Refusal{"p", CalibrationFault::NotANumber, [](CameraInfo& sent) { sent.p[11] = kNan; }, "number 11 is nan"},
        Refusal{"binning_y", CalibrationFault::OutOfRange, [](CameraInfo& sent) { sent.binning_y = 1001; },
                "is 1001, more than 1000"},
        Refusal{"roi.width", CalibrationFault::OutOfRange, [](CameraInfo& sent) { sent.roi.width = 65536; },
                "is 65536, more than 65535"}));

TEST(RefusedCalibrations, are_short_whatever_a_peer_sends) {
  CameraInfo info = calibrated();
  info.distortion_model = std::string(100'000, 'x');
  EXPECT_LT(check_camera_info(info, 640, 480).error().text().size(), 300U);
}

}  // namespace
}  // namespace nacelle::camera
