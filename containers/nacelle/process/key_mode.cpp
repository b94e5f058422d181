// SPDX-License-Identifier: Apache-2.0
#include "process/key_mode.hpp"

#include <unistd.h>

namespace nacelle::process {

KeyMode::KeyMode() {
  if (::tcgetattr(STDIN_FILENO, &before_) != 0) return;
  // A background process that changes its terminal is stopped by SIGTTOU.
  const pid_t foreground = ::tcgetpgrp(STDIN_FILENO);
  if (foreground >= 0 && foreground != ::getpgrp()) return;
  termios raw = before_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);  // ISIG stays: Ctrl-C is a signal
  raw.c_cc[VMIN] = 1;
  raw.c_cc[VTIME] = 0;
  is_on_ = ::tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
}

KeyMode::~KeyMode() {
  if (is_on_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

}  // namespace nacelle::process
