// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lidar/protocol/sweep.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::lidar {

/// Directions of a scan, counter-clockwise from its x axis. Units: deg, from -180 to 360; `to` may lie beyond the zero.
struct Sector {
  double from_deg{}, to_deg{};
};

/// How beams become scans.
struct ScanOptions {
  std::size_t points = 450;       ///< Rays of every scan; angle_increment = 2 * pi / points. 450 is one turn at 10 Hz.
  bool counter_clockwise = true;  ///< REP 103. False keeps the device's clockwise sense (laser_scan_dir of the maker).
  double range_min_m = 0.02;      ///< Nearer is -Inf (REP 117).
  double range_max_m = 12.0;      ///< Farther is +Inf (REP 117).
  bool crop = false;              ///< Leave out device angles in [crop_min_deg, crop_max_deg]: they read NaN.
  double crop_min_deg = 135.0;    ///< Device angle: clockwise from its front mark, 0 to 360.
  double crop_max_deg = 225.0;
  std::vector<Sector> ignored{};  ///< These read NaN, too: struts of the robot.
  double offset_deg = 0.0;        ///< Turns the scan counter-clockwise in its frame: 180 puts the front mark behind.
};

/// One full turn. Ray i points to i * 2 * pi / points, counted counter-clockwise from the x axis (or clockwise, see
/// ScanOptions). A ray without a measurement is NaN, one whose light did not return is +Inf.
struct Scan {
  std::vector<float> ranges_m;
  std::vector<float> intensities;
  bool has_intensities = false;
  MonotonicTime first_beam{};  ///< When the rotor passed angle 0: the turn's first ray.
  Duration turn{};             ///< From this turn's first beam to the next turn's.
};

/// Collects beams into scans of one fixed length.
///
/// The device turns clockwise while the rays of a scan count counter-clockwise: ray i was measured at
/// first_beam + ((points - i) mod points) * turn / points (without an offset).
/// When several beams fall on one ray, the nearest wins, as in the makers' drivers: nothing near is ever hidden.
/// Threads: one. Allocates: in the constructor only.
class ScanAssembler {
 public:
  struct Stats {
    std::uint64_t points{};         ///< Taken so far, in all turns.
    std::uint64_t scans{};          ///< Complete turns.
    std::uint64_t dropped_turns{};  ///< Turns with a gap of half a turn or more, and the one before the first angle 0.
  };

  explicit ScanAssembler(const ScanOptions& options);

  /// Takes one sweep whose last beam was measured at `last_beam`; calls `on_scan(const Scan&)` when a turn is full.
  ///
  /// The scan is valid during the call. A turn ends where the rotor passes 360 deg.
  template <typename Sink>
  void add(const Sweep& sweep, MonotonicTime last_beam, Sink&& on_scan) {
    const std::size_t before_zero = follow_rotor(sweep, last_beam);
    take(sweep.beams.first(before_zero));
    if (before_zero < sweep.beams.size()) {
      if (finish_turn()) on_scan(static_cast<const Scan&>(finished_));
      take(sweep.beams.subspan(before_zero));
    }
    current_.has_intensities |= sweep.has_intensities;
  }

  /// Forgets the turn under way: bytes were lost.
  void restart();
  [[nodiscard]] const Stats& stats() const { return stats_; }

 private:
  std::size_t follow_rotor(const Sweep& sweep, MonotonicTime last_beam);
  bool finish_turn();
  void take(std::span<const Beam> beams);
  void clear(Scan& scan) const;

  const std::size_t points_;
  const bool counter_clockwise_;
  const float rays_per_deg_, offset_rays_, nearest_m_, farthest_m_;
  std::vector<std::uint8_t> ignored_;  ///< By ray: 1 where nothing is measured.
  Scan current_;
  Scan finished_;
  bool follows_ = false;        ///< The rotor's place is known.
  double rotor_deg_ = 0.0;      ///< The farthest that it has turned, in [0, 360) ...
  MonotonicTime rotor_time_{};  ///< ... and when.
  MonotonicTime zero_{};        ///< When it passed 0 last.
  bool turn_is_whole_ = false;
  Stats stats_;
};

}  // namespace nacelle::lidar
