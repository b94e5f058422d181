// SPDX-License-Identifier: Apache-2.0
#include "lidar/model/scan_assembler.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "nacelle/base/expect.hpp"

namespace nacelle::lidar {
namespace {
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
}  // namespace

ScanAssembler::ScanAssembler(const ScanOptions& options)
    : options_(options),
      // Whole millimetres, so that 12 m as the device counts it is in range in spite of rounding.
      nearest_mm_(std::round(options.range_min_m * 1000.0)),
      farthest_mm_(std::round(options.range_max_m * 1000.0)) {
  NACELLE_EXPECT(options.points > 0, "a scan has rays");
  for (Scan* scan : {&current_, &finished_}) {
    scan->ranges_m.resize(options.points);
    scan->intensities.resize(options.points);
    clear(*scan);
  }
}

void ScanAssembler::clear(Scan& scan) const {
  std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), kNothing);
  std::fill(scan.intensities.begin(), scan.intensities.end(), 0.0F);
}

void ScanAssembler::restart() {
  if (turn_is_whole_) ++stats_.dropped_turns;
  turn_is_whole_ = false;
  last_angle_cdeg_ = -1.0;
  clear(current_);
}

void ScanAssembler::begin_frame(const Ld06Frame& frame, MonotonicTime last_point) {
  if (last_angle_cdeg_ < 0.0 || frame.speed_dps == 0) return;
  // After half a turn without a frame it is unknown whether angle 0 was passed.
  const Duration half_turn = from_seconds(180.0 / frame.speed_dps);
  if (last_point - last_point_ > half_turn) restart();
}

MonotonicTime ScanAssembler::time_of_point(const Ld06Frame& frame, MonotonicTime last_point, std::size_t i) {
  if (frame.speed_dps == 0) return last_point;
  const double behind = static_cast<double>(frame.points.size() - 1 - i) / static_cast<double>(frame.points.size() - 1);
  return last_point - from_seconds(frame.span_cdeg() / 100.0 * behind / frame.speed_dps);
}

bool ScanAssembler::passes_zero(double angle_cdeg) {
  const bool passes = last_angle_cdeg_ >= 0.0 && angle_cdeg + 18000.0 < last_angle_cdeg_;
  last_angle_cdeg_ = angle_cdeg;
  return passes;
}

bool ScanAssembler::finish_turn(MonotonicTime next_first_beam) {
  const bool whole = std::exchange(turn_is_whole_, true);
  if (whole) {
    std::swap(current_, finished_);
    finished_.turn = next_first_beam - finished_.first_beam;
    ++stats_.scans;
  } else {
    ++stats_.dropped_turns;
  }
  clear(current_);
  current_.first_beam = next_first_beam;
  return whole;
}

void ScanAssembler::take(double angle_cdeg, Ld06Point point) {
  ++stats_.points;
  const double angle_deg = angle_cdeg / 100.0;
  if (options_.crop && angle_deg >= options_.crop_min_deg && angle_deg <= options_.crop_max_deg) return;
  const auto points = static_cast<double>(options_.points);
  const auto clockwise = static_cast<std::size_t>(std::lround(angle_cdeg * points / 36000.0)) % options_.points;
  const std::size_t ray = options_.counter_clockwise ? (options_.points - clockwise) % options_.points : clockwise;

  float range_m = static_cast<float>(point.range_mm * 1e-3);
  if (point.range_mm == 0 || point.range_mm > farthest_mm_) {
    range_m = kInfinity;
  } else if (point.range_mm < nearest_mm_) {
    range_m = -kInfinity;
  }
  float& held = current_.ranges_m[ray];
  if (std::isnan(held) || range_m < held) {
    held = range_m;
    current_.intensities[ray] = static_cast<float>(point.intensity);
  }
}

}  // namespace nacelle::lidar
