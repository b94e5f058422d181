// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "control/wire.hpp"
#include "drive/drive.hpp"
#include "drive/model/load_track.hpp"
#include "drive/model/path_track.hpp"
#include "drive/odometry_tap.hpp"
#include "nacelle/base/time.hpp"
#include "run_page/figures.hpp"

namespace nacelle::drive {

/// Takes samples of a run for its page.
/// Threads: one. Memory: bounded.
class RunRecorder {
 public:
  static constexpr Duration kPosePeriod = 100ms, kStatsPeriod = 250ms;

  /// `odometry`: none if there is no such topic.
  RunRecorder(std::string truth_file, std::optional<OdometryTap> odometry, MonotonicTime begin, WallTime began_at)
      : truth_file_(std::move(truth_file)),
        odometry_(std::move(odometry)),
        begin_(begin),
        next_pose_(begin),
        began_at_(began_at) {}

  /// Notes the truth, and each tenth of a second where odometry and EKF are. `X_OB`: odom -> base.
  void note_pose(const control::TransformAnswer& X_OB, MonotonicTime now, WallTime wall_now);
  /// Notes counters and faults of the container's live figures.
  void note_stats(const nlohmann::json& stats, MonotonicTime now);

  /// Returns the figures for the page. `report`: the container's, with the drive's; null if the container left none.
  [[nodiscard]] run_page::Figures figures(const nlohmann::ordered_json& report, const DriveSettings& settings) const;

 private:
  std::string truth_file_;
  std::optional<OdometryTap> odometry_;
  MonotonicTime begin_, next_pose_;
  WallTime began_at_;
  double time_s_ = 0.0;  // of the last sample
  PathTrack path_;
  LoadTrack load_;
  std::vector<std::string> faults_;
  std::set<std::string> seen_faults_;
};

}  // namespace nacelle::drive
