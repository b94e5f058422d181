// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "lidar/protocol/lidar_protocol.hpp"

namespace nacelle::lidar {

/// Which protocol a model speaks.
enum class LidarFamily : std::uint8_t {
  Ld,       ///< LDROBOT: only sends.
  Rplidar,  ///< SLAMTEC: commanded.
  Ydlidar   ///< YDLIDAR: the X2 only sends, the others are commanded.
};

/// What is known about a model before it says anything: the defaults of the parameters, and how to read it.
struct LidarModel {
  std::string_view name;          ///< Value of the parameter `model`.
  std::string_view product_name;  ///< In the maker's ROS driver; empty if that has none.
  LidarFamily family = LidarFamily::Ld;
  unsigned baud = 230400;
  unsigned points_per_second = 4500;
  std::size_t scan_points = 450;  ///< Points of a turn at the usual speed.
  double range_min_m = 0.02, range_max_m = 12.0;
  bool has_intensities = false;  ///< YDLIDAR: three bytes a sample instead of two.
  bool is_commanded = false;     ///< YDLIDAR: takes commands.
};

/// All models, the default first.
[[nodiscard]] std::span<const LidarModel> lidar_models();
/// The model of this name, or null.
[[nodiscard]] const LidarModel* find_lidar_model(std::string_view name);
/// The model that the maker's ROS driver calls so, or null.
[[nodiscard]] const LidarModel* find_lidar_product(std::string_view product_name);

}  // namespace nacelle::lidar
