// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "camera/port/capture_port.hpp"
#include "camera/port/v4l2_device.hpp"

namespace nacelle::camera {

/// Returns the problem of a failed system call, with a CameraFault and a way out. `step` names the call; `os_code` is -errno.
[[nodiscard]] Problem describe_trouble(const std::string& device, std::string_view step, int os_code);

/// The same for a step of V4l2Device::start(): the driver may not take memory of that kind.
[[nodiscard]] Problem describe_start(const CaptureWish& wish, std::string_view step, int os_code);

/// Checks that the device is a camera, and agrees with it on format, size and rate: the nearest to the wish that it
/// has.
///
/// Errors: CameraFault::NotACamera; UnreadableFormat, with the formats of the device; UnusableSize; that of a failed call.
[[nodiscard]] Result<CaptureFormat, Problem> negotiate(const V4l2Device& device, const CaptureWish& wish);

/// The device's controls that are numbers or switches.
[[nodiscard]] std::vector<Control> list_controls(const V4l2Device& device);

/// "White Balance, Automatic" becomes "white_balance_automatic", as v4l2_camera names its parameters.
[[nodiscard]] std::string parameter_name(std::string_view control_name);

}  // namespace nacelle::camera
