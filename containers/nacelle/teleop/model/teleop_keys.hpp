// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle::teleop {

struct TeleopOptions {
  double speed_mps = 0.2;
  double yaw_rate_rps = 0.8;
  double top_speed_mps = 1.0, top_yaw_rate_rps = 3.0;
  /// A terminal does not report the release of a key. A held key repeats, first after about half a second; this long
  /// without a repetition counts as a release.
  Duration release_after = 600ms;
  Duration period = 50ms;  ///< Time between two commands while a key is held.
};

/// The effect of a key press.
enum class KeyEffect : std::uint8_t {
  Drive,     ///< u i o j l m , .
  Stop,      ///< k, space, and any other key, as in teleop_twist_keyboard.
  Faster,    ///< q w e z x c: changed the speeds, up or down.
  Holonomic  ///< t, b and the shifted keys: the base cannot move like this, and stops.
};

/// Forward speed in m/s and yaw rate in rad/s, counter-clockwise positive.
struct TeleopCommand {
  double speed_mps = 0, yaw_rate_rps = 0;
  friend bool operator==(const TeleopCommand&, const TeleopCommand&) = default;
};

/// Turns key presses into commands, in teleop_twist_keyboard's layout.
///
/// Source: ros2/teleop_twist_keyboard, teleop_twist_keyboard.py (moveBindings, speedBindings).
/// Threads: one. Allocates: nothing.
class TeleopKeys {
 public:
  explicit TeleopKeys(const TeleopOptions& options);

  KeyEffect press(char key, MonotonicTime now);
  /// Returns the command to send now, or nothing. After a release it returns five zero commands, then nothing.
  [[nodiscard]] std::optional<TeleopCommand> due(MonotonicTime now);

  [[nodiscard]] double speed_mps() const { return options_.speed_mps; }
  [[nodiscard]] double yaw_rate_rps() const { return options_.yaw_rate_rps; }
  [[nodiscard]] TeleopCommand command() const { return command_; }

 private:
  TeleopOptions options_;
  TeleopCommand command_;
  bool held_ = false;
  int zeros_left_ = 0;
  MonotonicTime pressed_at_;
  std::optional<MonotonicTime> sent_at_;
};

}  // namespace nacelle::teleop
