// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace nacelle::camera {

/// A distortion model and the number of its coefficients.
struct DistortionModel {
  std::string_view name;
  std::size_t coefficients;
};

/// The models of sensor_msgs. Source: ros2/common_interfaces jazzy, sensor_msgs/distortion_models.hpp; CameraInfo.msg.
inline constexpr std::array<DistortionModel, 3> kDistortionModels{
    {{"plumb_bob", 5}, {"rational_polynomial", 8}, {"equidistant", 4}}};

/// Returns how many coefficients a model has; 0 for one that is not known.
[[nodiscard]] constexpr std::size_t coefficients_of(std::string_view model) {
  for (const DistortionModel& known : kDistortionModels) {
    if (known.name == model) return known.coefficients;
  }
  return 0;
}

[[nodiscard]] inline std::vector<std::string> distortion_model_names() {
  std::vector<std::string> names;
  for (const DistortionModel& known : kDistortionModels) names.emplace_back(known.name);
  return names;
}

}  // namespace nacelle::camera
