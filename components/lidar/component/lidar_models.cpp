// SPDX-License-Identifier: Apache-2.0
#include "lidar/component/lidar_models.hpp"

#include <algorithm>
#include <array>

namespace nacelle::lidar {
namespace {

// Point rates and baud rates: ldrobotSensorTeam/ldlidar_stl_ros2 (lipkg.cpp, launch/). Ranges: the makers' data sheets.
constexpr std::array kModels{
    LidarModel{.name = "ld06", .product_name = "LDLiDAR_LD06"},
    LidarModel{.name = "ld19", .product_name = "LDLiDAR_LD19"},
    LidarModel{.name = "stl19p",
               .product_name = "LDLiDAR_STL19P",
               .points_per_second = 5000,
               .scan_points = 500,
               .range_min_m = 0.03},
    LidarModel{.name = "stl27l",
               .product_name = "LDLiDAR_STL27L",
               .baud = 921600,
               .points_per_second = 21600,
               .scan_points = 2160,
               .range_min_m = 0.03,
               .range_max_m = 25.0},
};

}  // namespace

std::span<const LidarModel> lidar_models() { return kModels; }

const LidarModel* find_lidar_model(std::string_view name) {
  const auto* found = std::ranges::find(kModels, name, &LidarModel::name);
  return found == kModels.end() ? nullptr : found;
}

const LidarModel* find_lidar_product(std::string_view product_name) {
  if (product_name.empty()) return nullptr;
  const auto* found = std::ranges::find(kModels, product_name, &LidarModel::product_name);
  return found == kModels.end() ? nullptr : found;
}

}  // namespace nacelle::lidar
