// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/baud.hpp"

// The kernel's termios2; <termios.h> defines the same names otherwise, so that this file is compiled by itself.
#include <asm/termbits.h>
#include <sys/ioctl.h>

namespace nacelle::io {

bool set_baud_by_number(int descriptor, unsigned baud) {
  termios2 options{};
  if (::ioctl(descriptor, TCGETS2, &options) != 0) return false;
  constexpr tcflag_t kBothSpeeds = static_cast<tcflag_t>(CBAUD) | static_cast<tcflag_t>(CBAUD) << IBSHIFT;
  options.c_cflag &= ~kBothSpeeds;
  options.c_cflag |= static_cast<tcflag_t>(BOTHER) | static_cast<tcflag_t>(BOTHER) << IBSHIFT;
  options.c_ispeed = options.c_ospeed = baud;
  return ::ioctl(descriptor, TCSETS2, &options) == 0;
}

unsigned baud_of(int descriptor) {
  termios2 options{};
  return ::ioctl(descriptor, TCGETS2, &options) == 0 ? options.c_ospeed : 0;
}

}  // namespace nacelle::io
