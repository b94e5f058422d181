// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ekf/model/measurement_queue.hpp"
#include "ekf/model/preparation.hpp"
#include "ekf/model/process_model.hpp"
#include "ekf/model/statistics.hpp"

namespace nacelle::ekf {

struct FilterOptions {
  ProcessNoise process_noise;
  Belief initial;
  Duration sensor_timeout = 33ms;  ///< Without a measurement for this long the state is carried on to now.
  bool two_d_mode = true;
  bool predict_to_current_time = false;
  bool dynamic_process_noise = false;
  std::size_t queue_capacity = 64;
  std::size_t parts = 0;  ///< How many parts of inputs there are; they are numbered from 0.
};

/// The running filter: a belief, the measurements that wait, and what became of each.
///
/// Measurements are taken in the order of their stamps when step() comes. One that is older than the filter corrects it
/// without a prediction, as in robot_localization without smoothing; one from the future waits for its time.
/// Threads: one. Allocates: in the constructor only.
class Filter {
 public:
  explicit Filter(const FilterOptions& options);

  /// Counts a part of a message and lets `prepare(Reading&) -> Prepared` fill it in, unless it is too old to matter.
  template <typename F>
  void offer(std::uint16_t part, WallTime stamp, F&& prepare) {
    Measurement* const place = admit(part, stamp);
    if (place == nullptr) return;
    const Prepared prepared = prepare(place->reading);
    settle(*place, prepared);
  }

  /// Fuses what is due at `now`. A clock that was set back moves the filter's stamps with it, one that was set ahead does not
  /// carry the robot away; the estimate holds in both cases.
  void step(WallTime now);

  struct Output {
    WallTime stamp;
    const Belief* belief;
  };
  /// The belief to publish at `now`, with a stamp newer than any before: the filter's own, or, if no measurement came since
  /// the last one, the same carried on to `now` (the filter itself is not moved by that). Nothing before the first
  /// measurement, or when the clock stands or went back.
  [[nodiscard]] std::optional<Output> output(WallTime now);

  /// Starts again from a pose at a stamp; everything older is ignored from now on.
  /// Errors: Covariance if the 6x6 block is not positive definite.
  [[nodiscard]] Prepared set_pose(const Reading& pose, WallTime stamp);
  /// Back to before the first measurement; counters stay.
  void reset();

  [[nodiscard]] bool initialised() const { return initialised_; }
  [[nodiscard]] const Belief& belief() const { return belief_; }
  [[nodiscard]] WallTime stamp() const { return stamp_; }
  [[nodiscard]] Turning turning() const;
  [[nodiscard]] const PartStats& stats(std::size_t part) const { return parts_[part].stats; }
  [[nodiscard]] std::uint64_t repairs() const { return repairs_; }
  /// How often the wall clock was seen to be set (or the filter was off for more than ten seconds).
  [[nodiscard]] std::uint64_t clock_steps() const { return clock_steps_; }

 private:
  struct Part {
    PartStats stats;
    WallTime newest{};
    bool seen{false};
  };
  [[nodiscard]] Measurement* admit(std::uint16_t part, WallTime stamp);
  void settle(Measurement& place, const Prepared& prepared);
  void process(const Measurement& measurement);
  [[nodiscard]] bool initialise_from(const Reading& reading);
  void advance_to(WallTime stamp);
  void drop_waiting(Rejection cause);
  void follow_clock_back(WallTime now);

  FilterOptions options_;
  Belief belief_;
  Belief carried_;  // what output() publishes when the filter itself is older
  MeasurementQueue queue_;
  std::vector<Part> parts_;
  WallTime stamp_{};
  WallTime last_step_{};
  WallTime last_output_{};
  WallTime last_set_pose_{};
  Eigen::Vector3d earlier_rates_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d alpha_ = Eigen::Vector3d::Zero();
  WallTime earlier_stamp_{};
  std::uint64_t repairs_{0};
  std::uint64_t clock_steps_{0};
  bool initialised_{false};
};

}  // namespace nacelle::ekf
