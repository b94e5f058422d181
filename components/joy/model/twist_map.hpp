// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace nacelle::joy {

/// A velocity of a body in its own frame: x forward, y left, z up. Units: m/s, rad/s.
struct PadTwist {
  double x{}, y{}, z{}, roll{}, pitch{}, yaw{};
  friend bool operator==(const PadTwist&, const PadTwist&) = default;
};

/// From the axes and buttons of a gamepad to a velocity, with the rules of teleop_twist_joy.
///
/// The turbo button counts before the enable button. An index of -1, or one that the message does not have, is an axis at rest or a
/// button that is up.
/// Source:  ros2/teleop_twist_joy, teleop_twist_joy.cpp.
/// Threads: const. Allocates: nothing.
class TwistMap {
 public:
  /// One direction of the velocity.
  struct Direction {
    std::int64_t axis = -1;
    double scale = 0.0, turbo_scale = 0.0;
  };
  struct Settings {
    bool require_enable_button = true;
    std::int64_t enable_button = 5, turbo_button = -1;
    bool inverted_reverse = false;  ///< Turn the other way round while driving backwards, as a car's wheel does.
    Direction x{5, 0.5, 1.0}, y{}, z{}, roll{}, pitch{}, yaw{2, 0.5, 1.0};
  };
  struct Outcome {
    bool enabled = false;
    PadTwist twist{};  ///< Zero unless enabled.
  };

  explicit TwistMap(const Settings& settings) : settings_(settings) {}
  [[nodiscard]] Outcome of(std::span<const float> axes, std::span<const std::int32_t> buttons) const;

 private:
  Settings settings_;
};

}  // namespace nacelle::joy
