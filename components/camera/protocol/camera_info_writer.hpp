// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "camera/protocol/camera_info_yaml.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "sensor_msgs/msg/camera_info.hpp"

namespace nacelle::camera {

/// Checks a calibration for images of a size, in pixels: that size, a known distortion model with its number of coefficients,
/// numbers that are finite, and a region that parse_camera_info() accepts.
///
/// Errors: a CalibrationFault; `where` is the field of the message.
[[nodiscard]] Result<void, Problem> check_camera_info(const sensor_msgs::msg::CameraInfo& info, std::uint32_t width,
                                                      std::uint32_t height);

/// Returns the YAML that camera_info_manager writes. parse_camera_info() reads the same message from it, bit for bit, if
/// check_camera_info() accepts the message; the header is left out.
/// Source: image_common jazzy, camera_calibration_parsers/src/parse_yml.cpp; binning and region, which that one leaves out, only
/// where they are not zero.
[[nodiscard]] std::string camera_info_yaml(const Calibration& calibration);

}  // namespace nacelle::camera
