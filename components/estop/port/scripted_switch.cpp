// SPDX-License-Identifier: Apache-2.0
#include "estop/port/scripted_switch.hpp"

#include <utility>

namespace nacelle::estop {

Result<bool, SwitchFault> ScriptedSwitch::is_pressed() {
  const LockGuard lock{mutex_};
  if (lost_) return err(SwitchFault::Lost);
  return pressed_;
}

Result<bool, SwitchFault> ScriptedSwitch::wait_until(MonotonicTime) {
  UniqueLock lock{mutex_};
  changed_.wait(lock.raw(), [this]() NACELLE_REQUIRES(mutex_) { return std::exchange(news_, false); });
  if (lost_) return err(SwitchFault::Lost);
  return std::exchange(changed_state_, false);
}

void ScriptedSwitch::interrupt() noexcept {
  const LockGuard lock{mutex_};
  news_ = true;
  changed_.notify_all();
}

void ScriptedSwitch::press(bool pressed) {
  const LockGuard lock{mutex_};
  pressed_ = pressed;
  news_ = changed_state_ = true;
  changed_.notify_all();
}

void ScriptedSwitch::lose() {
  const LockGuard lock{mutex_};
  lost_ = news_ = true;
  changed_.notify_all();
}

}  // namespace nacelle::estop
