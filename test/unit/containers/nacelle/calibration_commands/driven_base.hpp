// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "calibration_commands/model/base_estimate.hpp"

namespace nacelle::calibration {

/// A base on the floor whose wheels are what `real` says, and slip; encoders of 1440 counts a turn, read at 50 Hz.
class DrivenBase {
 public:
  DrivenBase(const BaseGeometry& real, const SlipNoise& slip, std::uint64_t seed)
      : real_(real), slip_(slip), draws_(seed) {}

  /// Begins a new way; the base stands at the origin of its measurements.
  void begin() {
    x_m_ = y_m_ = yaw_rad_ = 0.0;
    zero_ = counted();
    path_ = {{}};
  }
  void straight(double distance_m) { move(distance_m, 0.0); }
  void turn(double angle_rad) { move(0.0, angle_rad); }
  /// Four sides and four corners; to the left or to the right.
  void square(double side_m, bool is_left) {
    for (int i = 0; i < 4; ++i) {
      straight(side_m);
      turn(is_left ? std::numbers::pi / 2.0 : -std::numbers::pi / 2.0);
    }
  }
  /// The way so far, with errors of the measurement.
  [[nodiscard]] DrivenWay way(Measured what, double position_stddev_m = 0.0, double yaw_stddev_rad = 0.0) {
    std::normal_distribution<double> normal;
    DrivenWay driven{path_, what};
    driven.x_m = (what == Measured::Distance ? std::hypot(x_m_, y_m_) : x_m_) + position_stddev_m * normal(draws_);
    driven.y_m = y_m_ + position_stddev_m * normal(draws_);
    driven.yaw_rad = std::remainder(yaw_rad_ + yaw_stddev_rad * normal(draws_), 2.0 * std::numbers::pi);
    return driven;
  }

 private:
  /// Steps of 1 cm or so, as 50 Hz gives them at 0.5 m/s.
  void move(double distance_m, double angle_rad) {
    std::normal_distribution<double> normal;
    const double b = real_.separation_m();
    const int steps = 1 + static_cast<int>((std::abs(distance_m) + std::abs(angle_rad) * b / 2.0) / 0.01);
    for (int i = 0; i < steps; ++i) {
      const double ds = distance_m / steps, da = angle_rad / steps;
      const double length_m = std::max(std::abs(ds), std::abs(da) * b / 2.0);
      left_rad_ += (ds - da * b / 2.0) / real_.left_radius_m();
      right_rad_ += (ds + da * b / 2.0) / real_.right_radius_m();
      const double moved_m = ds + std::sqrt(slip_.distance_m * length_m) * normal(draws_);
      const double turned_rad =
          da + std::sqrt(slip_.heading_per_m * length_m + slip_.heading_per_rad * std::abs(da)) * normal(draws_);
      x_m_ += moved_m * std::cos(yaw_rad_ + turned_rad / 2.0);
      y_m_ += moved_m * std::sin(yaw_rad_ + turned_rad / 2.0);
      yaw_rad_ += turned_rad;
      path_.push_back(counted() - zero_);
    }
  }
  [[nodiscard]] WheelTurn counted() const {
    constexpr double kCount_rad = 2.0 * std::numbers::pi / 1440.0;
    return {kCount_rad * std::floor(left_rad_ / kCount_rad), kCount_rad * std::floor(right_rad_ / kCount_rad)};
  }

  const BaseGeometry real_;
  const SlipNoise slip_;
  std::mt19937_64 draws_;
  WheelTurn zero_;
  WheelPath path_;
  double left_rad_ = 0.0, right_rad_ = 0.0;
  double x_m_ = 0.0, y_m_ = 0.0, yaw_rad_ = 0.0;
};

/// The default robot.
inline BaseGeometry nominal_base() {
  BaseGeometry base;
  base.wheel_radius_m = 0.033;
  base.wheel_separation_m = 0.30;
  return base;
}

inline constexpr SlipNoise kNoSlip{0.0, 0.0, 0.0};
inline constexpr SlipNoise kLittleSlip{2.5e-6, 2.5e-5, 2.5e-5};  // 1.6 mm and 0.29 degrees after a metre
inline constexpr SlipNoise kMuchSlip{1e-5, 1e-4, 1e-4};          // 3.2 mm and 0.57 degrees

inline BaseGeometry real_base() {
  BaseGeometry base = nominal_base();
  base.left_radius_multiplier = 1.021;
  base.right_radius_multiplier = 1.013;
  base.separation_multiplier = 0.964;
  return base;
}

/// What an operator measures: a line, and the ends of squares each way, to 3 mm.
inline std::vector<DrivenWay> by_hand(std::uint64_t seed, const SlipNoise& slip, int squares, double side_m) {
  DrivenBase base{real_base(), slip, seed};
  std::vector<DrivenWay> ways;
  base.begin();
  base.straight(4.0);
  ways.push_back(base.way(Measured::Distance, 0.003));
  for (const bool is_left : {false, true}) {
    for (int i = 0; i < squares; ++i) {
      base.begin();
      base.square(side_m, is_left);
      ways.push_back(base.way(Measured::Position, 0.003));
    }
  }
  return ways;
}

/// What another localisation measures: where each leg ends, to 1 mm and 1 mrad.
inline std::vector<DrivenWay> by_topic(std::uint64_t seed, const SlipNoise& slip, int squares, double side_m) {
  DrivenBase base{real_base(), slip, seed};
  std::vector<DrivenWay> ways;
  for (const bool is_left : {false, true}) {
    for (int leg = 0; leg < 4 * squares; ++leg) {
      base.begin();
      base.straight(side_m);
      ways.push_back(base.way(Measured::Pose, 0.001, 0.001));
      base.begin();
      base.turn(is_left ? 1.5708 : -1.5708);
      ways.push_back(base.way(Measured::Pose, 0.001, 0.001));
    }
  }
  return ways;
}

}  // namespace nacelle::calibration
