// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/truth_topic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calibration_commands/topic_reader.hpp"
#include "cli/program.hpp"

namespace nacelle::cli {
namespace {

constexpr Duration kListen = 200ms;
constexpr double kMostMotion_m = 0.05;

}  // namespace

FloorPose seen_from(const FloorPose& here, const FloorPose& there) {
  const double c = std::cos(here.yaw_rad), s = std::sin(here.yaw_rad);
  const double dx = there.x_m - here.x_m, dy = there.y_m - here.y_m;
  return {c * dx + s * dy, c * dy - s * dx, std::remainder(there.yaw_rad - here.yaw_rad, 2.0 * std::numbers::pi)};
}

std::optional<FloorPose> floor_pose_in(const nlohmann::json& message) {
  try {
    const nlohmann::json& outer = message.at("pose");
    const nlohmann::json& pose = outer.contains("pose") ? outer.at("pose") : outer;
    const auto number = [&](const char* part, const char* name) { return pose.at(part).at(name).get<double>(); };
    const double x = number("orientation", "x"), y = number("orientation", "y"), z = number("orientation", "z"),
                 w = number("orientation", "w");
    return FloorPose{number("position", "x"), number("position", "y"),
                     std::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)};
  } catch (const nlohmann::json::exception&) { return std::nullopt; }
}

Result<FloorPose, int> measure_pose(const Dialogue& dialogue, const std::string& container, const std::string& topic,
                                    Duration silence) {
  const SystemClock clock;
  std::optional<MonotonicTime> first_at;
  FloorPose first, sum;  // the sum of what the poses are beyond the first one
  double farthest_m = 0.0;
  int count = 0;
  bool is_pose = true;
  const int code = collect(dialogue, container, topic, silence, [&](const nlohmann::json& message) {
    const auto pose = floor_pose_in(message);
    is_pose = pose.has_value();
    if (!pose) return false;
    if (!first_at) {
      first_at = clock.now();
      first = *pose;
    }
    const double dx = pose->x_m - first.x_m, dy = pose->y_m - first.y_m;
    sum.x_m += dx;
    sum.y_m += dy;
    sum.yaw_rad += std::remainder(pose->yaw_rad - first.yaw_rad, 2.0 * std::numbers::pi);
    farthest_m = std::max(farthest_m, std::hypot(dx, dy));
    ++count;
    return clock.now() - *first_at < kListen;
  });
  if (code != kDone) return err(code);
  if (!is_pose)
    return err(complain({"topic " + topic, "is not of poses",
                         "name one of nav_msgs/Odometry, geometry_msgs/PoseStamped or PoseWithCovarianceStamped"}));
  if (farthest_m > kMostMotion_m)
    return err(complain({"topic " + topic, fmt::format("the pose moves by {:.2f} m while the robot stands", farthest_m),
                         "take a better localisation, or measure by hand"}));
  return FloorPose{first.x_m + sum.x_m / count, first.y_m + sum.y_m / count, first.yaw_rad + sum.yaw_rad / count};
}

}  // namespace nacelle::cli
