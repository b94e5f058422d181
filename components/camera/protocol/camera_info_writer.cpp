// SPDX-License-Identifier: Apache-2.0
#include "camera/protocol/camera_info_writer.hpp"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "camera/protocol/calibration_fault.hpp"
#include "camera/protocol/distortion_model.hpp"

namespace nacelle::camera {
namespace {

constexpr const char* kRunAgain = "calibrate with images of this camera";

Problem wrong(const char* field, CalibrationFault fault, std::string value, std::string what, std::string way_out) {
  return {std::string("camera_info.") + field, std::move(what), std::move(way_out), fault, std::move(value)};
}

Result<void, Problem> check_numbers(const char* field, std::span<const double> numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (std::isfinite(numbers[i])) continue;
    return err(wrong(field, CalibrationFault::NotANumber, fmt::format("{}", numbers[i]),
                     fmt::format("number {} is {}", i, numbers[i]), kRunAgain));
  }
  return {};
}

Result<void, Problem> check_distortion(const sensor_msgs::msg::CameraInfo& info) {
  const std::string model{std::string_view{info.distortion_model}.substr(0, 40)};  // any peer may have sent it
  const std::size_t wanted = coefficients_of(info.distortion_model);
  if (wanted == 0) {
    return err(wrong("distortion_model", CalibrationFault::UnknownModel, model, fmt::format("'{}' is not known", model),
                     suggestion(model, distortion_model_names())));
  }
  if (info.d.size() == wanted) return {};
  return err(wrong("d", CalibrationFault::WrongShape, std::to_string(info.d.size()),
                   fmt::format("{} has {} coefficients, not {}", model, wanted, info.d.size()), kRunAgain));
}

Result<void, Problem> check_at_most(const char* field, std::uint32_t number, std::uint32_t most) {
  if (number <= most) return {};
  return err(wrong(field, CalibrationFault::OutOfRange, std::to_string(number),
                   fmt::format("is {}, more than {}", number, most), "0 means the whole picture"));
}

/// A number that YAML 1.1 and 1.2 read as a floating one, and from_chars as the same bits.
std::string number_text(double number) {
  std::string text = fmt::format("{}", number);
  if (text.find('.') != std::string::npos) return text;
  const auto exponent = text.find('e');
  return text.insert(exponent == std::string::npos ? text.size() : exponent, ".0");
}

std::string quoted(std::string_view text) {
  std::string all = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < ' ' || byte == 0x7F) {
      all += fmt::format("\\x{:02X}", byte);
      continue;
    }
    if (c == '"' || c == '\\') all += '\\';
    all += c;
  }
  return all + '"';
}

std::string matrix(const char* name, std::size_t rows, std::span<const double> numbers) {
  std::string data;
  for (const double number : numbers) data += (data.empty() ? "" : ", ") + number_text(number);
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: [{}]\n", name, rows, numbers.size() / rows, data);
}

}  // namespace

Result<void, Problem> check_camera_info(const sensor_msgs::msg::CameraInfo& info, std::uint32_t width,
                                        std::uint32_t height) {
  if (info.width != width || info.height != height) {
    return err(wrong("width", CalibrationFault::WrongSize, fmt::format("{}x{}", info.width, info.height),
                     fmt::format("the calibration is for {}x{} pixels, the images have {}x{}", info.width, info.height,
                                 width, height),
                     kRunAgain));
  }
  if (auto fine = check_distortion(info); !fine) return fine;
  for (const auto& [field, numbers] :
       {std::pair<const char*, std::span<const double>>{"d", info.d}, {"k", info.k}, {"r", info.r}, {"p", info.p}}) {
    if (auto fine = check_numbers(field, numbers); !fine) return fine;
  }
  for (const auto& [field, number, most] :
       {std::tuple{"binning_x", info.binning_x, kMostBinning}, std::tuple{"binning_y", info.binning_y, kMostBinning},
        std::tuple{"roi.x_offset", info.roi.x_offset, kMostCalibratedPixels},
        std::tuple{"roi.y_offset", info.roi.y_offset, kMostCalibratedPixels},
        std::tuple{"roi.height", info.roi.height, kMostCalibratedPixels},
        std::tuple{"roi.width", info.roi.width, kMostCalibratedPixels}}) {
    if (auto fine = check_at_most(field, number, most); !fine) return fine;
  }
  return {};
}

std::string camera_info_yaml(const Calibration& calibration) {
  const auto& info = calibration.info;
  std::string text = fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", info.width, info.height,
                                 quoted(calibration.camera_name));
  text += matrix("camera_matrix", 3, info.k);
  text += fmt::format("distortion_model: {}\n", std::string_view{info.distortion_model});
  text += matrix("distortion_coefficients", 1, info.d);
  text += matrix("rectification_matrix", 3, info.r);
  text += matrix("projection_matrix", 3, info.p);
  if (info.binning_x != 0 || info.binning_y != 0)
    text += fmt::format("binning_x: {}\nbinning_y: {}\n", info.binning_x, info.binning_y);
  const auto& roi = info.roi;
  if (roi != sensor_msgs::msg::RegionOfInterest{}) {
    text += fmt::format("roi:\n  x_offset: {}\n  y_offset: {}\n  height: {}\n  width: {}\n  do_rectify: {}\n",
                        roi.x_offset, roi.y_offset, roi.height, roi.width, roi.do_rectify);
  }
  return text;
}

}  // namespace nacelle::camera
