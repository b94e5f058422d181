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
/// A beam at the zero belongs to the new turn, whatever the rounding.
constexpr double kZeroDeg = 360.0 - 1e-6;

/// Into [0, 360).
double wrapped(double deg) {
  const double rest = std::fmod(deg, 360.0);
  return rest < 0.0 ? rest + 360.0 : rest;
}

bool lies_in(double deg, const Sector& sector) {
  return wrapped(deg - sector.from_deg) <= std::min(sector.to_deg - sector.from_deg, 360.0);
}

/// Which rays are left out.
std::vector<std::uint8_t> ignored_rays(const ScanOptions& options) {
  std::vector<std::uint8_t> ignored(options.points, 0);
  for (std::size_t ray = 0; ray < options.points; ++ray) {
    const double along_deg = static_cast<double>(ray) * 360.0 / static_cast<double>(options.points);
    const double left_deg = options.counter_clockwise ? along_deg : wrapped(-along_deg);
    const double device_deg = wrapped(options.offset_deg - left_deg);
    bool is_ignored = options.crop && device_deg >= options.crop_min_deg && device_deg <= options.crop_max_deg;
    for (const Sector& sector : options.ignored) is_ignored |= lies_in(left_deg, sector);
    ignored[ray] = is_ignored ? 1 : 0;
  }
  return ignored;
}

}  // namespace

ScanAssembler::ScanAssembler(const ScanOptions& options)
    : points_(options.points),
      counter_clockwise_(options.counter_clockwise),
      rays_per_deg_(static_cast<float>(static_cast<double>(options.points) / 360.0)),
      // The offset counts to the left, the device to the right.
      offset_rays_(static_cast<float>(wrapped(-options.offset_deg) / 360.0 * static_cast<double>(options.points))),
      nearest_m_(static_cast<float>(options.range_min_m)),
      farthest_m_(static_cast<float>(options.range_max_m)) {
  NACELLE_EXPECT(options.points > 0, "a scan has rays");
  ignored_ = ignored_rays(options);
  for (Scan* scan : {&current_, &finished_}) {
    scan->ranges_m.resize(options.points);
    scan->intensities.resize(options.points);
    clear(*scan);
  }
}

void ScanAssembler::clear(Scan& scan) const {
  std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), kNothing);
  std::fill(scan.intensities.begin(), scan.intensities.end(), 0.0F);
  scan.has_intensities = false;
}

void ScanAssembler::restart() {
  if (turn_is_whole_) ++stats_.dropped_turns;
  turn_is_whole_ = false;
  follows_ = false;
  clear(current_);
}

/// Moves the rotor on and returns how many beams were measured before it passed 0.
std::size_t ScanAssembler::follow_rotor(const Sweep& sweep, MonotonicTime last_beam) {
  const auto steps = static_cast<std::int64_t>(sweep.beams.size() - 1);
  const MonotonicTime first_beam = last_beam - steps * sweep.period;
  // After half a turn without a packet it is unknown whether angle 0 was passed.
  if (follows_ && sweep.speed_dps > 0.0 && to_seconds(first_beam - rotor_time_) * sweep.speed_dps > 180.0) restart();

  const double span_deg = static_cast<double>(steps) * sweep.rotor_step_deg;
  double ahead_deg = follows_ ? sweep.first_rotor_deg - rotor_deg_ : 0.0;
  if (ahead_deg < -180.0) ahead_deg += 360.0;
  if (ahead_deg > 180.0) ahead_deg -= 360.0;
  const double from_deg = follows_ ? rotor_deg_ : sweep.first_rotor_deg;
  const double first_deg = from_deg + ahead_deg;  // may be behind `from`, and beyond 360
  const double last_deg = first_deg + span_deg;
  std::size_t before_zero = sweep.beams.size();
  if (last_deg >= kZeroDeg) {
    if (first_deg >= kZeroDeg) {
      before_zero = 0;
      const double share = ahead_deg > 0.0 ? (first_deg - 360.0) / ahead_deg : 0.0;
      zero_ = first_beam - Duration{std::llround(share * static_cast<double>((first_beam - rotor_time_).count()))};
    } else {
      const double beams = (360.0 - first_deg) / sweep.rotor_step_deg;
      before_zero = static_cast<std::size_t>(std::min(std::ceil(beams - 1e-6), static_cast<double>(steps)));
      zero_ = first_beam + Duration{std::llround(beams * static_cast<double>(sweep.period.count()))};
    }
  }
  if (!follows_ || last_deg > from_deg) {
    rotor_deg_ = last_deg >= kZeroDeg ? std::max(last_deg - 360.0, 0.0) : last_deg;
    rotor_time_ = last_beam;
  }
  follows_ = true;
  return before_zero;
}

bool ScanAssembler::finish_turn() {
  const bool whole = std::exchange(turn_is_whole_, true);
  if (whole) {
    std::swap(current_, finished_);
    finished_.turn = zero_ - finished_.first_beam;
    ++stats_.scans;
  } else {
    ++stats_.dropped_turns;
  }
  clear(current_);
  current_.first_beam = zero_;
  return whole;
}

void ScanAssembler::take(std::span<const Beam> beams) {
  stats_.points += beams.size();
  for (const Beam& beam : beams) {
    auto clockwise = static_cast<std::size_t>(beam.angle_deg * rays_per_deg_ + offset_rays_ + 0.5F);
    while (clockwise >= points_) clockwise -= points_;
    const std::size_t ray = counter_clockwise_ && clockwise != 0 ? points_ - clockwise : clockwise;
    if (ignored_[ray] != 0) continue;

    float range_m = beam.range_m;
    if (range_m == 0.0F || range_m > farthest_m_) {
      range_m = kInfinity;
    } else if (range_m < nearest_m_) {
      range_m = -kInfinity;
    }
    float& held = current_.ranges_m[ray];
    if (!(held <= range_m)) {  // NaN, too: nothing was measured there yet
      held = range_m;
      current_.intensities[ray] = beam.intensity;
    }
  }
}

}  // namespace nacelle::lidar
