// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "sensor_msgs/msg/camera_info.hpp"

namespace nacelle::camera {

/// Limits of what a calibration may say: of a side or an offset in pixels, and of a binning.
inline constexpr std::uint32_t kMostCalibratedPixels = 65535, kMostBinning = 1000;

/// A calibration file's content.
struct Calibration {
  std::string camera_name;            ///< "unknown" when the file does not say.
  sensor_msgs::msg::CameraInfo info;  ///< The header is left empty.
};

/// Reads the YAML that camera_calibration and camera_info_manager write.
///
/// Errors: a CalibrationFault (calibration_fault.hpp); `where` is the line of `file_name`.
/// Source: image_common jazzy, camera_calibration_parsers/src/parse_yml.cpp.
[[nodiscard]] Result<Calibration, Problem> parse_camera_info(std::string_view yaml, const std::string& file_name);

}  // namespace nacelle::camera
