// SPDX-License-Identifier: Apache-2.0
#include "lidar/component/lidar_models.hpp"

#include <algorithm>
#include <array>

namespace nacelle::lidar {
namespace {

// LDROBOT's point rates and baud rates: ldrobotSensorTeam/ldlidar_stl_ros2 (lipkg.cpp, launch/). An RPLIDAR says its point rate itself;
// scan_points is one turn of its recommended mode at 10 Hz (A1: 5.5 Hz). Ranges: the makers' data sheets.
// YDLIDAR's rates and ranges: YDLIDAR/YDLidar-SDK, doc/Dataset.md.
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
    LidarModel{
        .name = "rplidar_a1", .family = LidarFamily::Rplidar, .baud = 115200, .scan_points = 720, .range_min_m = 0.15},
    LidarModel{
        .name = "rplidar_a2", .family = LidarFamily::Rplidar, .baud = 115200, .scan_points = 800, .range_min_m = 0.15},
    LidarModel{.name = "rplidar_a3",
               .family = LidarFamily::Rplidar,
               .baud = 256000,
               .scan_points = 1600,
               .range_min_m = 0.15,
               .range_max_m = 25.0},
    LidarModel{
        .name = "rplidar_c1", .family = LidarFamily::Rplidar, .baud = 460800, .scan_points = 500, .range_min_m = 0.05},
    LidarModel{.name = "rplidar_s1",
               .family = LidarFamily::Rplidar,
               .baud = 256000,
               .scan_points = 920,
               .range_min_m = 0.1,
               .range_max_m = 40.0},
    LidarModel{.name = "rplidar_s2",
               .family = LidarFamily::Rplidar,
               .baud = 1000000,
               .scan_points = 3200,
               .range_min_m = 0.05,
               .range_max_m = 30.0},
    LidarModel{.name = "rplidar_s3",
               .family = LidarFamily::Rplidar,
               .baud = 1000000,
               .scan_points = 3200,
               .range_min_m = 0.05,
               .range_max_m = 40.0},
    LidarModel{.name = "ydlidar_x2",
               .family = LidarFamily::Ydlidar,
               .baud = 115200,
               .points_per_second = 3000,
               .scan_points = 430,
               .range_min_m = 0.1,
               .range_max_m = 8.0},
    LidarModel{.name = "ydlidar_x4",
               .family = LidarFamily::Ydlidar,
               .baud = 128000,
               .points_per_second = 5000,
               .scan_points = 720,
               .range_min_m = 0.12,
               .range_max_m = 10.0,
               .is_commanded = true},
    LidarModel{.name = "ydlidar_g2",
               .family = LidarFamily::Ydlidar,
               .baud = 230400,
               .points_per_second = 5000,
               .scan_points = 500,
               .range_min_m = 0.28,
               .range_max_m = 16.0,
               .has_intensities = true,
               .is_commanded = true},
    LidarModel{.name = "ydlidar_g4",
               .family = LidarFamily::Ydlidar,
               .baud = 230400,
               .points_per_second = 9000,
               .scan_points = 900,
               .range_min_m = 0.28,
               .range_max_m = 16.0,
               .is_commanded = true},
    LidarModel{.name = "ydlidar_g6",
               .family = LidarFamily::Ydlidar,
               .baud = 512000,
               .points_per_second = 18000,
               .scan_points = 1800,
               .range_min_m = 0.28,
               .range_max_m = 25.0,
               .is_commanded = true},
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
