// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lidar/protocol/ld06_frame.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::lidar {

/// How points become scans.
struct ScanOptions {
  std::size_t points = 450;       ///< Rays of every scan; angle_increment = 2 * pi / points. 450 is one turn at 10 Hz.
  bool counter_clockwise = true;  ///< REP 103. False keeps the device's clockwise sense (laser_scan_dir of the maker).
  double range_min_m = 0.02;      ///< Nearer is -Inf (REP 117).
  double range_max_m = 12.0;      ///< Farther is +Inf (REP 117).
  bool crop = false;              ///< Leave out device angles in [crop_min_deg, crop_max_deg]: they read NaN.
  double crop_min_deg = 135.0;    ///< Device angle: clockwise from its front mark, 0 to 360.
  double crop_max_deg = 225.0;
};

/// One full turn. Ray i points to i * 2 * pi / points, counted counter-clockwise from the x axis (or clockwise, see
/// ScanOptions). A ray without a measurement is NaN, one whose light did not return is +Inf.
struct Scan {
  std::vector<float> ranges_m;
  std::vector<float> intensities;
  MonotonicTime first_beam{};  ///< When the turn's first ray was measured: the one at angle 0.
  Duration turn{};             ///< From this turn's first beam to the next turn's.
};

/// Collects the points of a turn into scans of one fixed length.
///
/// The device turns clockwise while the rays of a scan count counter-clockwise: ray i was measured at
/// first_beam + ((points - i) mod points) * turn / points.
/// When several points fall on one ray, the nearest wins, as in the maker's driver: nothing near is ever hidden.
/// Threads: one. Allocates: in the constructor only.
class ScanAssembler {
 public:
  struct Stats {
    std::uint64_t points{};         ///< Taken so far, in all turns.
    std::uint64_t scans{};          ///< Complete turns.
    std::uint64_t dropped_turns{};  ///< Turns with a gap of half a turn or more, and the one before the first angle 0.
  };

  explicit ScanAssembler(const ScanOptions& options);

  /// Takes one frame whose last point was measured at `last_point`; calls `on_scan(const Scan&)` when a turn is full.
  ///
  /// The scan is valid during the call. A turn ends where the device's angle passes 360 deg.
  template <typename Sink>
  void add(const Ld06Frame& frame, MonotonicTime last_point, Sink&& on_scan) {
    begin_frame(frame, last_point);
    for (std::size_t i = 0; i < frame.points.size(); ++i) {
      const double angle_cdeg = frame.angle_cdeg(i);
      const MonotonicTime measured = time_of_point(frame, last_point, i);
      if (passes_zero(angle_cdeg) && finish_turn(measured)) on_scan(static_cast<const Scan&>(finished_));
      take(angle_cdeg, frame.points[i]);
    }
    last_point_ = last_point;
  }

  /// Forgets the turn under way: bytes were lost.
  void restart();
  [[nodiscard]] const Stats& stats() const { return stats_; }

 private:
  void begin_frame(const Ld06Frame& frame, MonotonicTime last_point);
  [[nodiscard]] static MonotonicTime time_of_point(const Ld06Frame& frame, MonotonicTime last_point, std::size_t i);
  [[nodiscard]] bool passes_zero(double angle_cdeg);
  bool finish_turn(MonotonicTime next_first_beam);
  void take(double angle_cdeg, Ld06Point point);
  void clear(Scan& scan) const;

  const ScanOptions options_;
  const double nearest_mm_, farthest_mm_;
  Scan current_;
  Scan finished_;
  double last_angle_cdeg_ = -1.0;  // negative: no point yet
  MonotonicTime last_point_{};
  bool turn_is_whole_ = false;
  Stats stats_;
};

}  // namespace nacelle::lidar
