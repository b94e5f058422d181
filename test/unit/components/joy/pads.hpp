// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <linux/input-event-codes.h>

#include "joy/model/pad_info.hpp"

namespace nacelle::joy {

/// What an Xbox 360 pad reports. Source: drivers/input/joystick/xpad.c of the kernel.
inline PadInfo xbox_pad() {
  PadInfo pad;
  pad.name = "Microsoft X-Box 360 pad";
  pad.path = "/dev/input/event7";
  for (const unsigned code :
       {BTN_A, BTN_B, BTN_X, BTN_Y, BTN_TL, BTN_TR, BTN_SELECT, BTN_START, BTN_MODE, BTN_THUMBL, BTN_THUMBR})
    pad.buttons.set(code);
  for (const unsigned code : {ABS_X, ABS_Y, ABS_RX, ABS_RY}) pad.axes[code] = PadAxis{0, -32768, 32767};
  for (const unsigned code : {ABS_Z, ABS_RZ}) pad.axes[code] = PadAxis{0, 0, 255};
  for (const unsigned code : {ABS_HAT0X, ABS_HAT0Y}) pad.axes[code] = PadAxis{0, -1, 1};
  return pad;
}

// Indices in the message.
inline constexpr std::size_t kXboxA = 0, kXboxLeftShoulder = 4, kXboxRightShoulder = 5;
inline constexpr std::size_t kXboxLeftX = 0, kXboxLeftY = 1, kXboxLeftTrigger = 2, kXboxRightX = 3, kXboxRightY = 4,
                             kXboxHatX = 6, kXboxHatY = 7;

}  // namespace nacelle::joy
