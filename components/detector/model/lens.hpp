// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "sensor_msgs/msg/camera_info.hpp"

namespace nacelle::detector {

/// A direction in the camera's optical frame: the point where it meets the plane one metre ahead.
struct Direction {
  double x, y;
};

/// Where a pixel looks to. Frame: optical (x right, y down, z forward).
///
/// Source: pinhole with the distortion of OpenCV's and ROS's models plumb_bob, rational_polynomial (Brown-Conrady, k1
///         k2 p1 p2 k3 [k4 k5 k6]) and equidistant (Kannala-Brandt), inverted by fixed-point steps.
/// Threads: a value. Allocates: nothing.
class Lens {
 public:
  /// From a calibration; nothing if the camera is not calibrated or the numbers are no lens.
  [[nodiscard]] static std::optional<Lens> from(const sensor_msgs::msg::CameraInfo& info);
  /// An ideal lens with the given horizontal angle of view. Preconditions: the angle is in (0, pi).
  [[nodiscard]] static Lens assumed(std::uint32_t width, std::uint32_t height, double horizontal_view_rad);

  [[nodiscard]] Direction direction_of(double u_px, double v_px) const;
  /// Geometric mean of both focal lengths: how many pixels a radian is in the middle.
  [[nodiscard]] double focal_px() const;

 private:
  enum class Model : std::uint8_t { Brown, Equidistant };
  double fx_px_ = 0, fy_px_ = 0, cu_px_ = 0, cv_px_ = 0;
  Model model_ = Model::Brown;
  std::array<double, 8> d_{};
  bool distorts_ = false;
};

}  // namespace nacelle::detector
