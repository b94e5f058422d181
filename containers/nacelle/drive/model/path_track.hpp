// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "drive/model/square_course.hpp"
#include "drive/model/thinned_log.hpp"
#include "nacelle/base/time.hpp"
#include "run_page/figures.hpp"

namespace nacelle::drive {

struct StampedPose {
  WallTime at{};
  PlanarPose pose;
};

/// Returns the distance of two poses, and the angle between them. Pure.
[[nodiscard]] run_page::PoseError error_between(const PlanarPose& pose, const PlanarPose& truth);

/// Compares poses of odometry and EKF with the truth at their own stamps, because a pose is older than the truth that is read beside it.
///
/// Frame: odom, which begins where the world does. Threads: one. Memory: bounded.
class PathTrack {
 public:
  /// Adds a truth. Call it at least at the rate of add(); times that do not rise are ignored.
  void note_truth(const StampedPose& truth);
  /// Adds a sample of the run. A pose that is unknown, or older than the kept truths (five seconds), has no error.
  void add(double time_s, const std::optional<StampedPose>& odometry, const std::optional<StampedPose>& ekf);

  [[nodiscard]] bool has_truth() const { return !truths_.empty(); }
  [[nodiscard]] std::vector<run_page::PathSample> samples() const { return log_.samples(); }

 private:
  [[nodiscard]] run_page::PoseError error_of(const StampedPose& pose) const;
  [[nodiscard]] std::optional<PlanarPose> truth_at(WallTime at) const;

  std::deque<StampedPose> truths_;
  ThinnedLog<run_page::PathSample> log_{2048};
};

}  // namespace nacelle::drive
