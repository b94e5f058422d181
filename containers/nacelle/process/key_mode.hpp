// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <termios.h>

namespace nacelle::process {

/// Switches the terminal of stdin to single keys without echo while the object exists. Ctrl-C still raises SIGINT.
///
/// Changes nothing if stdin is not a terminal, or if the process runs in the background.
class KeyMode {
 public:
  KeyMode();
  KeyMode(const KeyMode&) = delete;
  KeyMode& operator=(const KeyMode&) = delete;
  ~KeyMode();

  /// Returns whether the terminal was switched.
  [[nodiscard]] bool is_on() const { return is_on_; }

 private:
  bool is_on_ = false;
  termios before_{};
};

}  // namespace nacelle::process
