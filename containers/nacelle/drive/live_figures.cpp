// SPDX-License-Identifier: Apache-2.0
#include "drive/live_figures.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace nacelle::drive {

double yaw_of(const std::array<double, 4>& rotation_xyzw) {
  const auto [x, y, z, w] = rotation_xyzw;
  return std::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

PlanarPose planar(const control::TransformAnswer& X) {
  return {X.translation_m[0], X.translation_m[1], yaw_of(X.rotation_xyzw)};
}

std::vector<Problem> faults_of(const nlohmann::json& stats) {
  std::vector<Problem> faults;
  for (const auto& node : stats["nodes"]) {
    const std::string where = "component " + node["name"].get<std::string>();
    if (node.contains("fault")) {
      faults.push_back({where, "is faulted: " + node["fault"].get<std::string>(), ""});
    } else if (node.contains("open_faults")) {
      faults.push_back({where, "has an open fault: " + node["open_faults"].front().get<std::string>(), ""});
    }
  }
  return faults;
}

}  // namespace nacelle::drive
