// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libcamera/camera.h>

#include <memory>
#include <optional>

#include "camera/port/capture_port.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::camera {

/// What a camera agreed to.
struct Agreement {
  std::unique_ptr<::libcamera::CameraConfiguration> configuration;  ///< Valid, of one stream.
  CaptureFormat format;
  std::optional<std::int64_t> frame_time_us;  ///< For FrameDurationLimits; nothing if the camera has no such control.
};

/// Agrees with an acquired camera on the nearest format that it has, with a remark where that is not the wish.
/// Errors: a CameraFault.
[[nodiscard]] Result<Agreement, Problem> agree(::libcamera::Camera& camera, const CaptureWish& wish, unsigned buffers);

}  // namespace nacelle::camera
