// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle::calibration {

/// A motion by a given amount: m and m/s of a straight line, rad and rad/s of a turn on the spot.
struct LegSettings {
  double target = 0.0;        ///< Positive.
  double speed = 0.0;         ///< Positive.
  double acceleration = 0.0;  ///< Positive; on the way up and on the way down, so that no wheel slips.

  /// No command for so long: the base has stopped by its own timeout (0.5 s) or is about to.
  Duration late_after = 400ms;
  /// Zeros for so long let a base move again that stopped by its timeout.
  Duration pause = 1s;
  Duration stalled_after = 2s;    ///< Without motion although it is commanded: a pause, and once more.
  int most_stalls = 5;            ///< One after another.
  Duration silent_after = 500ms;  ///< Without a reading of the wheels: the base is stopped.
  Duration lost_after = 5s;       ///< Without a reading: given up.
  Duration still_for = 500ms;     ///< At the end: the wheels have stopped.
};

enum class LegState : std::uint8_t {
  Driving,
  Pausing,   ///< Zeros are sent for a while.
  Stopping,  ///< The target is reached; the wheels roll out.
  Done,
  Stalled,  ///< Given up: the wheels do not follow.
  Lost,     ///< Given up: there are no readings of the wheels.
  Astray,   ///< Given up: the wheels went backward, or far beyond the target; a board that was restarted looks so, too.
};

/// Decides what a leg commands, from readings of the wheels. Every end commands zero.
///
/// Times are arguments. Threads: one. Allocates: nothing.
class Leg {
 public:
  Leg(const LegSettings& settings, MonotonicTime now);

  /// Takes a reading: how far the wheels say that the base has come since the beginning.
  void take(double progress, MonotonicTime now);
  /// Returns the speed to command now; call it once for each command. Take the readings that are there first.
  [[nodiscard]] double command(MonotonicTime now);

  [[nodiscard]] LegState state() const { return state_; }
  [[nodiscard]] bool is_over() const { return state_ > LegState::Stopping; }
  [[nodiscard]] double progress() const { return progress_; }

 private:
  void pause(MonotonicTime now);

  const LegSettings settings_;
  LegState state_ = LegState::Driving;
  double progress_ = 0.0, speed_ = 0.0;
  double moved_to_ = 0.0;  // the last position that counts as another one
  MonotonicTime moved_at_, heard_at_, pause_until_{};
  std::optional<MonotonicTime> commanded_at_;
  int stalls_ = 0, still_readings_ = 0;
};

}  // namespace nacelle::calibration
