// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
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
        turns_per_second_(settings.turns_per_second),
        aim_(settings.turns_per_second) {}

  /// When the next sample is measured.
  [[nodiscard]] Duration next_at() const { return next_at_; }
  /// Measures it.
  Sample next() {
    const double period_s = 1.0 / settings_.points_per_second;  // by its own clock
    Sample sample{.at = next_at_, .device_time_s = device_time_s_, .angle_deg = angle_deg_};
    sample.starts_turn = std::exchange(passed_zero_, false);
    sample.speed_dps = 360.0 * turns_per_second_;
    const double range_m = room_.range_m(0.0, 0.0, -angle_deg_ / 180.0 * std::numbers::pi);
    const double noise_m = draws_.normal(settings_.range_noise_m);
    if (range_m <= settings_.farthest_m) sample.range_m = std::max(range_m + noise_m, 0.001);

    device_time_s_ += period_s;
    const double true_period_s = period_s / (1.0 + settings_.clock_error);
    // The speed loop follows a new aim with a time constant of half a second.
    turns_per_second_ += (aim_ - turns_per_second_) * true_period_s / 0.5;
    const double step_deg = 360.0 * turns_per_second_ * true_period_s;
    const double before_s = true_time_s_;
    true_time_s_ += true_period_s;
    next_at_ = from_seconds(true_time_s_);
    angle_deg_ += step_deg;
    if (angle_deg_ >= 360.0) {
      angle_deg_ -= 360.0;
      passed_zero_ = true;
      zeros_.push_back(from_seconds(before_s + true_period_s * (1.0 - angle_deg_ / step_deg)));
    }
    return sample;
  }
  /// Lets the motor go to another speed.
  void aim_at(double turns_per_second) { aim_ = turns_per_second; }
  /// A motor that stands needs no half second to be at rest; the next sample is measured `now` at the earliest.
  void jump_to(Duration now) {
    true_time_s_ = std::max(true_time_s_, to_seconds(now));
    next_at_ = from_seconds(true_time_s_);
  }
  /// When the rotor passed the angle 0, each time so far. A truth that no device tells.
  [[nodiscard]] const std::vector<Duration>& zeros() const { return zeros_; }
  [[nodiscard]] const Settings& settings() const { return settings_; }

 private:
  static constexpr std::uint64_t kStream = 16;

  const Settings settings_;
  const Room room_;
  Random draws_;
  double turns_per_second_, aim_;
  double angle_deg_ = 0.0, device_time_s_ = 0.0, true_time_s_ = 0.0;
  Duration next_at_{};
  bool passed_zero_ = true;
  std::vector<Duration> zeros_;
};

}  // namespace nacelle::simulation
