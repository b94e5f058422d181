// SPDX-License-Identifier: Apache-2.0
#include "drive/model/path_track.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::drive {
namespace {

constexpr Duration kKept = 5s;
constexpr double kTurn = 2 * M_PI;

run_page::Position position_of(const std::optional<StampedPose>& pose) {
  return pose ? run_page::Position{pose->pose.x_m, pose->pose.y_m} : run_page::Position{};
}

}  // namespace

run_page::PoseError error_between(const PlanarPose& pose, const PlanarPose& truth) {
  return {std::hypot(pose.x_m - truth.x_m, pose.y_m - truth.y_m),
          std::abs(std::remainder(pose.yaw_rad - truth.yaw_rad, kTurn)) * 180 / M_PI};
}

void PathTrack::note_truth(const StampedPose& truth) {
  if (!truths_.empty() && truth.at <= truths_.back().at) return;
  truths_.push_back(truth);
  while (truths_.size() > 2 && truth.at - truths_.front().at > kKept) truths_.pop_front();
}

std::optional<PlanarPose> PathTrack::truth_at(WallTime at) const {
  const auto next =
      std::find_if(truths_.begin(), truths_.end(), [&](const StampedPose& truth) { return truth.at >= at; });
  // The newest stamp may lie a little after the newest truth.
  if (next == truths_.end()) return truths_.empty() ? std::nullopt : std::optional{truths_.back().pose};
  if (next->at == at) return next->pose;
  if (next == truths_.begin()) return std::nullopt;
  const StampedPose& before = *(next - 1);
  const double part = to_seconds(at - before.at) / to_seconds(next->at - before.at);
  const auto between = [part](double a, double b) { return a + part * (b - a); };
  return PlanarPose{between(before.pose.x_m, next->pose.x_m), between(before.pose.y_m, next->pose.y_m),
                    // The truth's yaw counts turns.
                    between(before.pose.yaw_rad, next->pose.yaw_rad)};
}

run_page::PoseError PathTrack::error_of(const StampedPose& pose) const {
  const auto truth = truth_at(pose.at);
  return truth ? error_between(pose.pose, *truth) : run_page::PoseError{};
}

void PathTrack::add(double time_s, const std::optional<StampedPose>& odometry, const std::optional<StampedPose>& ekf) {
  run_page::PathSample sample;
  sample.time_s = time_s;
  if (!truths_.empty()) sample.truth = position_of(truths_.back());
  sample.odometry = position_of(odometry);
  sample.ekf = position_of(ekf);
  if (odometry) sample.odometry_error = error_of(*odometry);
  if (ekf) sample.ekf_error = error_of(*ekf);
  log_.add(sample);
}

}  // namespace nacelle::drive
