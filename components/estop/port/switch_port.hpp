// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::estop {

/// Why a switch cannot be read. Readers then treat it as pressed.
enum class SwitchFault : std::uint8_t {
  Lost,  ///< The kernel refuses to read the line: the chip was removed.
};

/// A switch that stops the robot while it is pressed.
///
/// Threads: one; interrupt() from any. Allocates: nothing after it was made.
class SwitchPort {
 public:
  SwitchPort() = default;
  SwitchPort(const SwitchPort&) = delete;
  SwitchPort& operator=(const SwitchPort&) = delete;
  virtual ~SwitchPort() = default;

  /// How it is now.
  [[nodiscard]] virtual Result<bool, SwitchFault> is_pressed() = 0;
  /// Waits for a change, the deadline or interrupt(); true: it changed, if only for a moment.
  [[nodiscard]] virtual Result<bool, SwitchFault> wait_until(MonotonicTime deadline) = 0;
  /// Makes a waiting wait_until() return at once.
  virtual void interrupt() noexcept = 0;
};

}  // namespace nacelle::estop
