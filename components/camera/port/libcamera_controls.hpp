// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libcamera/controls.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "camera/port/capture_port.hpp"

namespace nacelle::camera {

/// "ExposureTime" as a parameter's name: "exposure_time".
[[nodiscard]] std::string control_parameter_name(std::string_view control_name);

/// Those controls of a camera that are one number or a switch, by name. Numbers with a point count thousandths: "_milli" ends their
/// names.
[[nodiscard]] std::vector<Control> list_controls(const ::libcamera::ControlInfoMap& controls);

/// The value for libcamera of one that list_controls() listed; nothing if it is not of this camera.
[[nodiscard]] std::optional<::libcamera::ControlValue> control_value(const ::libcamera::ControlInfoMap& controls,
                                                                     unsigned id, std::int64_t value);

}  // namespace nacelle::camera
