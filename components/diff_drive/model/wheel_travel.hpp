// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "diff_drive/model/drive_kinematics.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

/// One report of a board about its wheels.
struct WheelReading {
  WheelRates rates;
  bool has_position = false;  ///< False: the board sends speeds only.
  double left_rad = 0.0;      ///< Angle turned, as the board counts it.
  double right_rad = 0.0;
};

/// Makes the wheels' angles continuous: across a counter that wraps, a board that restarts, and a pause.
///
/// Angles of a board without positions are integrated from its speeds.
/// Threads: one. Allocates: nothing.
class WheelTravel {
 public:
  struct Settings {
    double max_wheel_rate_rps = 100.0;  ///< No wheel turns twice as fast: a larger step is a restart of the board.
    double slack_rad = 3.0;             ///< Added to the largest step that is believed.
    double wrap_rad = 0.0;              ///< Positions repeat after so many rad; 0: never.
  };
  explicit WheelTravel(const Settings& settings) : settings_(settings) {}

  /// The next reading is the first after a pause: its position is where the wheels are, its time starts a new step.
  void pause() { has_reading_ = false; }
  /// Readings come in the order of their capture; an earlier time counts as the same.
  void advance(const WheelReading& reading, MonotonicTime captured_at);

  [[nodiscard]] double left_rad() const { return left_rad_; }
  [[nodiscard]] double right_rad() const { return right_rad_; }
  /// When the last reading was captured, never before the one that preceded it.
  [[nodiscard]] MonotonicTime captured_at() const { return captured_at_; }
  /// Times that the board's counters restarted.
  [[nodiscard]] std::uint64_t restarts() const { return restarts_; }

 private:
  [[nodiscard]] double step(double now_rad, double before_rad) const;

  const Settings settings_;
  bool has_reading_ = false;
  bool has_start_ = false;
  WheelReading last_;
  MonotonicTime captured_at_{};
  double left_rad_ = 0.0, right_rad_ = 0.0;
  std::uint64_t restarts_ = 0;
};

}  // namespace nacelle::diff_drive
