// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <mutex>

#include "estop/port/switch_port.hpp"

namespace nacelle::estop {

/// A switch that a test presses. Waits last until it does something, whatever their deadline. Threads: any.
class ScriptedSwitch final : public SwitchPort {
 public:
  Result<bool, SwitchFault> is_pressed() override;
  Result<bool, SwitchFault> wait_until(MonotonicTime deadline) override;
  void interrupt() noexcept override;

  void press(bool pressed);
  /// Every read fails from now on.
  void lose();

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool pressed_ = false, lost_ = false, news_ = false, changed_state_ = false;
};

}  // namespace nacelle::estop
