// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calibration_commands/dialogue.hpp"
#include "calibration_commands/gyro_reference.hpp"
#include "calibration_commands/topic_reader.hpp"
#include "calibration_commands/wheel_reading.hpp"
#include "drive/velocity_sender.hpp"

namespace nacelle::cli {

/// A leg that a base drives: straight ahead, or on the spot.
enum class LegKind : std::uint8_t { Straight, Turn };

/// Where a base is reached.
struct BaseTopics {
  std::string container, commands, joints, frame;
  bool stamped = true;    ///< TwistStamped; else Twist.
  Duration silence = 5s;  ///< Longest time without joint states.
};

/// Drives legs by the positions of the wheels, with a command each 20 ms while a leg lasts.
///
/// Threads: one.
class BaseDriver {
 public:
  BaseDriver(const Dialogue& dialogue, BaseTopics topics, BaseParameters base)
      : dialogue_(dialogue), topics_(std::move(topics)), base_(std::move(base)) {}

  /// Drives until the wheels say that the target is reached, and stand still. `target` in m or rad, `speed` in m/s or rad/s.
  /// Returns how far the wheels have turned. Whatever ends it, it commands zero and waits until that has arrived. `gyro` measures
  /// meanwhile; null: there is none.
  /// Errors: an exit code, printed: a signal, no joint states, wheels that do not follow or go astray, the container has ended.
  [[nodiscard]] Result<calibration::WheelTurn, int> drive(LegKind kind, double target, double speed,
                                                          GyroReference* gyro = nullptr);

 private:
  struct Way;
  [[nodiscard]] Result<calibration::WheelTurn, int> first_reading(TopicReader& joints) const;
  [[nodiscard]] Result<void, Problem> run(Way& way) const;

  const Dialogue& dialogue_;
  const BaseTopics topics_;
  const BaseParameters base_;
};

}  // namespace nacelle::cli
