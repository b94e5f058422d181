// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "image_proc/model/sampling_map.hpp"
#include "nacelle/base/result.hpp"
#include "sensor_msgs/msg/camera_info.hpp"

namespace nacelle::image_proc {

/// Why images cannot be rectified with a camera_info.
enum class CalibrationFault : std::uint8_t {
  Uncalibrated,  ///< The focal length of K is 0: the camera publishes no calibration.
  UnknownModel,  ///< The distortion model is neither plumb_bob nor rational_polynomial.
  BadNumbers,    ///< More coefficients than the model has, a number that is none, or matrices without an inverse.
  BadSize        ///< Sides of 0, above kMostSide, or more than kMostPixels pixels.
};
[[nodiscard]] const char* to_text(CalibrationFault fault);

/// Whether two camera_infos give the same map.
[[nodiscard]] bool same_lens(const sensor_msgs::msg::CameraInfo& a, const sensor_msgs::msg::CameraInfo& b);

/// Computes where each pixel of the rectified picture is in the camera's picture.
///
/// Without R (all zeros) the rectified camera looks where the camera does; without P (its focal length is 0) it has K.
/// Units:     pixels. Frame: rays are in the camera's optical frame (x right, y down, z forward).
/// Errors:    CalibrationFault; the message may come from anywhere.
/// Source:    OpenCV's documentation of initUndistortRectifyMap(), coefficients k1 k2 p1 p2 [k3 [k4 k5 k6]]; sensor_msgs/CameraInfo.
[[nodiscard]] Result<SamplingMap, CalibrationFault> rectification_map(const sensor_msgs::msg::CameraInfo& info,
                                                                      Interpolation interpolation);

}  // namespace nacelle::image_proc
