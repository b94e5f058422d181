// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libcamera/camera.h>
#include <libcamera/camera_manager.h>

#include <memory>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::camera {

/// A camera of libcamera, and what it lives in. The camera must end first, as it does with this object.
struct FoundCamera {
  std::shared_ptr<::libcamera::CameraManager> manager;
  std::shared_ptr<::libcamera::Camera> camera;
};

/// Finds the camera of a video_device: "libcamera:ID", "libcamera:1" by its number in libcamera's list, "libcamera" the first.
///
/// libcamera allows a process one manager: cameras that are open share it, and a search without an open camera looks at the
/// devices anew.
/// Errors: a CameraFault, with what there is.
/// Threads: any.
[[nodiscard]] Result<FoundCamera, Problem> find_camera(const std::string& name);

/// Says what an error number of a step (a verb: "acquire") means for a camera.
[[nodiscard]] Problem describe_libcamera_trouble(const std::string& name, const char* step, int os_code);

}  // namespace nacelle::camera
