// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>

#include "estop/port/switch_port.hpp"
#include "nacelle/base/mutex.hpp"

namespace nacelle::estop {

/// A switch that a test presses. Waits ignore their deadline and last until the test acts. Threads: any.
class ScriptedSwitch final : public SwitchPort {
 public:
  Result<bool, SwitchFault> is_pressed() override;
  Result<bool, SwitchFault> wait_until(MonotonicTime deadline) override;
  void interrupt() noexcept override;

  void press(bool pressed);
  /// Every read fails from now on.
  void lose();

 private:
  Mutex mutex_;
  std::condition_variable changed_;
  bool pressed_ NACELLE_GUARDED_BY(mutex_) = false;
  bool lost_ NACELLE_GUARDED_BY(mutex_) = false;
  bool news_ NACELLE_GUARDED_BY(mutex_) = false;
  bool changed_state_ NACELLE_GUARDED_BY(mutex_) = false;
};

}  // namespace nacelle::estop
