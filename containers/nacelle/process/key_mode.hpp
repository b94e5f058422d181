// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <termios.h>

namespace nacelle::process {

/// Delivers the keys of stdin one by one and unseen while the object lives. Ctrl-C stays a signal.
///
/// Changes nothing if stdin is no terminal, or the process runs in the background.
class KeyMode {
 public:
  KeyMode();
  KeyMode(const KeyMode&) = delete;
  KeyMode& operator=(const KeyMode&) = delete;
  ~KeyMode();

  /// Whether keys come.
  [[nodiscard]] bool is_on() const { return is_on_; }

 private:
  bool is_on_ = false;
  termios before_{};
};

}  // namespace nacelle::process
