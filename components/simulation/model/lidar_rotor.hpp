// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "nacelle/base/time.hpp"
#include "simulation/model/random.hpp"
#include "simulation/model/room.hpp"

namespace nacelle::simulation {

/// The turning head of a LiDAR in the middle of a room: where it looks, what it measures and when.
///
/// Its clock is its own: `clock_error` says by how much its quartz is fast. Clockwise seen from above, 0 ahead.
class LidarRotor {
 public:
  struct Settings {
    double points_per_second = 4500.0;
    double turns_per_second = 10.0;
    double farthest_m = 12.0;
    double range_noise_m = 0.005;
    double clock_error = 0.0;
    std::uint64_t seed = 1;
  };
  struct Sample {
    Duration at{};             ///< True time.
    double device_time_s{};    ///< By the device's clock.
    double angle_deg{};        ///< [0, 360)
    double range_m{};          ///< 0: nothing came back.
    double speed_dps{};        ///< Of the rotor at that time.
    bool starts_turn = false;  ///< The first sample after the angle 0.
  };

  LidarRotor(const Settings& settings, Room room)
      : settings_(settings),
        room_(std::move(room)),
        draws_(settings.seed, kStream),
        points_per_second_(settings.points_per_second),
        turns_per_second_(settings.turns_per_second),
        aim_(settings.turns_per_second) {}

  /// When the next sample is measured.
  [[nodiscard]] Duration next_at() const { return next_at_; }
  /// Distance to the wall in a direction of the device, clockwise; infinite without one.
  [[nodiscard]] double wall_m(double angle_deg) const {
    return room_.range_m(0.0, 0.0, -angle_deg / 180.0 * std::numbers::pi);
  }
  /// The angle at which the next sample is measured.
  [[nodiscard]] double next_angle_deg() const { return angle_deg_; }
  /// Measures it. A sensor that looks past its axis measures `offset_deg` before the rotor's angle.
  Sample next(double offset_deg = 0.0) {
    const double period_s = 1.0 / points_per_second_;  // by its own clock
    Sample sample{.at = next_at_, .device_time_s = device_time_s_, .angle_deg = angle_deg_};
    sample.starts_turn = std::exchange(passed_zero_, false);
    sample.speed_dps = 360.0 * turns_per_second_;
    const double range_m = wall_m(angle_deg_ - offset_deg);
    const double noise_m = draws_.normal(settings_.range_noise_m);
    if (range_m <= settings_.farthest_m) sample.range_m = std::max(range_m + noise_m, 0.001);

    device_time_s_ += period_s;
    const double true_period_s = period_s / (1.0 + settings_.clock_error);
    // The speed loop follows a new aim with a time constant of half a second.
    turns_per_second_ += (aim_ - turns_per_second_) * true_period_s / 0.5;
    const double step_deg = 360.0 * turns_per_second_ * true_period_s;
    note_zero(std::remainder(angle_deg_ - offset_deg, 360.0));
    true_time_s_ += true_period_s;
    next_at_ = from_seconds(true_time_s_);
    angle_deg_ += step_deg;
    if (angle_deg_ >= 360.0) {
      angle_deg_ -= 360.0;
      passed_zero_ = true;
    }
    return sample;
  }
  /// Another scan mode measures at another rate.
  void measure_at(double points_per_second) { points_per_second_ = points_per_second; }
  /// Lets the motor go to another speed.
  void aim_at(double turns_per_second) { aim_ = turns_per_second; }
  /// When the light passed the angle 0, each time so far. A truth that no device tells.
  [[nodiscard]] const std::vector<Duration>& zeros() const { return zeros_; }
  [[nodiscard]] const Settings& settings() const { return settings_; }

 private:
  static constexpr std::uint64_t kStream = 16;

  // `light_deg`: where the light goes now, -180 to 180. A correction that jumps there does not make a second zero of it.
  void note_zero(double light_deg) {
    const double ahead_deg = light_deg - light_deg_;
    const bool passes = light_deg_ < 0.0 && light_deg >= 0.0 && ahead_deg < 90.0;
    if (passes && (zeros_.empty() || true_time_s_ - to_seconds(zeros_.back()) > 0.5 / (turns_per_second_ + 1e-9)))
      zeros_.push_back(from_seconds(true_time_s_ - (true_time_s_ - light_time_s_) * light_deg / ahead_deg));
    light_deg_ = light_deg;
    light_time_s_ = true_time_s_;
  }

  const Settings settings_;
  const Room room_;
  Random draws_;
  double points_per_second_, turns_per_second_, aim_;
  double light_deg_ = 0.0, light_time_s_ = 0.0;
  double angle_deg_ = 0.0, device_time_s_ = 0.0, true_time_s_ = 0.0;
  Duration next_at_{};
  bool passed_zero_ = true;
  std::vector<Duration> zeros_;
};

}  // namespace nacelle::simulation
