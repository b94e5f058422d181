// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace nacelle::joy {

namespace pad_codes {
// Source: linux/input-event-codes.h; Documentation/input/gamepad.rst of the kernel.
inline constexpr std::size_t kKeyCount = 0x300, kAxisCount = 0x40;
inline constexpr std::size_t kFirstJoystickButton = 0x120, kFirstDigitizerButton = 0x140;  // BTN_JOYSTICK, BTN_DIGI
inline constexpr std::size_t kAxisX = 0x00, kFirstHat = 0x10, kLastHat = 0x17;  // ABS_X, ABS_HAT0X, ABS_HAT3Y
}  // namespace pad_codes

/// An axis as the device reports it, in counts.
struct PadAxis {
  std::int32_t value{}, minimum{}, maximum{};
};

/// What a gamepad has, and the state that it is in.
struct PadInfo {
  std::string name{};  ///< "Microsoft X-Box 360 pad"
  std::string path{};  ///< "/dev/input/event5"
  std::bitset<pad_codes::kKeyCount> buttons{}, pressed{};
  std::array<std::optional<PadAxis>, pad_codes::kAxisCount> axes{};
};

/// Tells whether this is a gamepad or joystick: it has a button of one, and two axes or a hat. A touchpad, a keyboard or a motion sensor
/// beside the buttons is none.
[[nodiscard]] bool is_gamepad(const PadInfo& pad);

}  // namespace nacelle::joy
