// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "calibration_commands/dialogue.hpp"
#include "calibration_commands/topic_reader.hpp"
#include "calibration_commands/wheel_reading.hpp"
#include "drive/velocity_sender.hpp"

namespace nacelle::cli {

/// What a leg commands: these, times the leg's speed. The speed counts what the leg is measured by.
struct Motion {
  double forward_mps = 0.0, yaw_rate_rps = 0.0;
};
/// Measured in m.
inline constexpr Motion kStraight{1.0, 0.0};
/// Measured in rad, positive.
inline constexpr Motion kTurnLeft{0.0, 1.0}, kTurnRight{0.0, -1.0};
[[nodiscard]] constexpr Motion arc_left(double radius_m) { return {radius_m, 1.0}; }
[[nodiscard]] constexpr Motion arc_right(double radius_m) { return {radius_m, -1.0}; }

/// Where a base is reached.
struct BaseTopics {
  std::string container, commands, joints, frame;
  bool stamped = true;         ///< TwistStamped; else Twist.
  Duration silence = 5s;       ///< Longest time without joint states.
  Duration still_for = 500ms;  ///< At the end of a leg: wheels that stand for so long have stopped.
};

/// Drives legs by the positions of the wheels, with a command each 20 ms while a leg lasts.
///
/// Threads: one.
class BaseDriver {
 public:
  BaseDriver(const Dialogue& dialogue, BaseTopics topics, BaseParameters base)
      : dialogue_(dialogue), topics_(std::move(topics)), base_(std::move(base)) {}

  /// Drives until the wheels say that the target is reached, and stand still. `target` in m or rad, `speed` in m/s or rad/s.
  /// Returns how far the wheels have turned. Whatever ends it, it commands zero and waits until that has arrived. `meanwhile` is
  /// called often, to read what else measures; its error ends the leg.
  /// Errors: an exit code, printed: a signal, no joint states, wheels that do not follow or go astray, the container has ended.
  [[nodiscard]] Result<calibration::WheelTurn, int> drive(const Motion& motion, double target, double speed,
                                                          const std::function<Result<void, Problem>()>& meanwhile = {});
  /// The readings of the wheels on the last leg, beginning with zero.
  [[nodiscard]] const std::vector<WheelSample>& path() const { return path_; }

 private:
  struct Way;
  [[nodiscard]] Result<WheelSample, int> first_reading(TopicReader& joints) const;
  [[nodiscard]] Result<void, Problem> run(Way& way);

  const Dialogue& dialogue_;
  const BaseTopics topics_;
  const BaseParameters base_;
  std::vector<WheelSample> path_;
};

}  // namespace nacelle::cli
