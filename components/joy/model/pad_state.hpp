// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "joy/model/pad_info.hpp"
#include "joy/protocol/input_event.hpp"

namespace nacelle::joy {

/// Turns events into the buttons and axes of a sensor_msgs/Joy.
///
/// Order, as ROS 2's joy: buttons by code from BTN_JOYSTICK (0x120) on, then those below; axes by code, then two for each hat. An axis is
/// +1 at the left and at the top (a trigger at rest), 0 within the dead zone, and grows steadily from its edge. Values beyond the range are
/// held at its end.
/// Source:  SDL 2, SDL_sysjoystick.c (order); joystick_drivers, joy.cpp (signs and dead zone).
/// Threads: one. Allocates: load() only.
class PadState {
 public:
  struct Settings {
    double deadzone = 0.05;       ///< Share of an axis' way to either side that counts as its middle; below 1.
    bool sticky_buttons = false;  ///< A press switches a button over, a release does nothing.
  };
  enum class Change : std::uint8_t { None, Axis, Button };

  explicit PadState(const Settings& settings) : settings_(settings) {}

  /// Takes over what the pad has and how it stands, also after lost events. Sticky buttons keep their state.
  void load(const PadInfo& pad);
  /// Takes one event of a key or axis; others, and codes that the pad does not have, are ignored.
  Change take(const InputEvent& event);

  [[nodiscard]] std::span<const float> axes() const { return axes_; }
  [[nodiscard]] std::span<const std::int32_t> buttons() const { return buttons_; }

 private:
  [[nodiscard]] float position(std::int32_t value, const PadAxis& range) const;

  static constexpr std::int16_t kNone = -1;
  const Settings settings_;
  std::array<std::int16_t, pad_codes::kKeyCount> button_of_{};
  std::array<std::int16_t, pad_codes::kAxisCount> axis_of_{};
  std::array<PadAxis, pad_codes::kAxisCount> ranges_{};
  std::vector<float> axes_;
  std::vector<std::int32_t> buttons_;
};

}  // namespace nacelle::joy
