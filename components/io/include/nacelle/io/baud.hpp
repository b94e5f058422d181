// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle::io {

/// Sets a terminal's speed by its number: for rates that termios has no name for, such as 128000 and 256000. Returns false if the
/// line refuses it. Source: ioctl_tty(2), TCSETS2 with BOTHER.
[[nodiscard]] bool set_baud_by_number(int descriptor, unsigned baud);
/// The speed that a terminal is set to, or 0.
[[nodiscard]] unsigned baud_of(int descriptor);

}  // namespace nacelle::io
