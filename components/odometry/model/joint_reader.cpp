// SPDX-License-Identifier: Apache-2.0
#include "odometry/model/joint_reader.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::odometry {
namespace {

constexpr double kShortestStep_s = 1e-4;  // diff_drive_controller: shorter ones divide noise by nothing

}  // namespace

JointReader::JointReader(const JointReaderOptions& options)
    : left_{options.left_names, std::vector<std::size_t>(options.left_names.size(), 0), options.left_radius_m},
      right_{options.right_names, std::vector<std::size_t>(options.right_names.size(), 0), options.right_radius_m},
      max_wheel_speed_rps_(options.max_wheel_speed_rps) {}

bool JointReader::mean_of(Side& side, std::span<const std::string> names, std::span<const double> positions_rad,
                          double& mean_rad) {
  double sum = 0.0;
  for (std::size_t i = 0; i < side.names.size(); ++i) {
    std::size_t& place = side.places[i];
    if (place >= names.size() || names[place] != side.names[i]) {
      place = static_cast<std::size_t>(std::find(names.begin(), names.end(), side.names[i]) - names.begin());
      if (place == names.size()) return false;
    }
    sum += positions_rad[place];
  }
  mean_rad = sum / static_cast<double>(side.names.size());
  return true;
}

std::optional<JointReader::Step> JointReader::read(WallTime stamp, std::span<const std::string> names,
                                                   std::span<const double> positions_rad) {
  ++stats_.samples;
  Sample now{stamp};
  if (names.size() != positions_rad.size() || !mean_of(left_, names, positions_rad, now.left_rad) ||
      !mean_of(right_, names, positions_rad, now.right_rad)) {
    ++stats_.incomplete;
    return std::nullopt;
  }
  if (!std::isfinite(now.left_rad) || !std::isfinite(now.right_rad)) {
    ++stats_.not_finite;
    return std::nullopt;
  }
  if (!last_) {
    ++stats_.first;
    last_ = now;
    return std::nullopt;
  }
  const double dt_s = to_seconds(stamp - last_->stamp);
  if (dt_s < 0.0) {
    ++stats_.time_jumps;
    last_ = now;
    return std::nullopt;
  }
  if (dt_s < kShortestStep_s) {
    ++stats_.repeated;
    return std::nullopt;
  }
  const double left_rad = now.left_rad - last_->left_rad;
  const double right_rad = now.right_rad - last_->right_rad;
  last_ = now;
  if (std::max(std::abs(left_rad), std::abs(right_rad)) > max_wheel_speed_rps_ * dt_s) {
    ++stats_.jumps;
    return std::nullopt;
  }
  ++stats_.steps;
  return Step{{left_rad * left_.radius_m, right_rad * right_.radius_m}, dt_s};
}

}  // namespace nacelle::odometry
