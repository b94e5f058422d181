// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/scripted_bus.hpp"

namespace nacelle::io {

Result<void, StreamFault> ScriptedBus::transfer(std::uint8_t address, ByteView out, ByteSpan in) {
  const LockGuard lock{mutex_};
  ++transfers_;
  if (fault_) return err(*fault_);
  if (lose_every_ > 0 && transfers_ % lose_every_ == 0) return err(StreamFault::NoAnswer);
  const auto& device = devices_[address & 0x7FU];
  if (!device || !device(out, in)) return err(StreamFault::NoAnswer);
  return {};
}

bool ScriptedBus::wait_until(MonotonicTime time) {
  UniqueLock lock{mutex_};
  if (time > allowed_ && !interrupted_) {
    waits_for_more_ = true;
    changed_.notify_all();
    changed_.wait(lock.raw(), [&]() NACELLE_REQUIRES(mutex_) { return interrupted_ || time <= allowed_; });
    waits_for_more_ = false;
  }
  if (std::exchange(interrupted_, false)) return false;
  if (wait_) wait_(time);
  return true;
}

void ScriptedBus::interrupt() noexcept {
  const LockGuard lock{mutex_};
  interrupted_ = true;
  changed_.notify_all();
}

Result<void, StreamFault> ScriptedBus::reopen() {
  const LockGuard lock{mutex_};
  return fault_ == StreamFault::NotFound ? Result<void, StreamFault>{err(StreamFault::NotFound)}
                                         : Result<void, StreamFault>{};
}

void ScriptedBus::attach(std::uint8_t address, Device device) {
  const LockGuard lock{mutex_};
  devices_[address & 0x7FU] = std::move(device);
}

void ScriptedBus::between_transfers(const std::function<void()>& change) {
  const LockGuard lock{mutex_};
  change();
}

void ScriptedBus::allow_until(MonotonicTime time) {
  const LockGuard lock{mutex_};
  allowed_ = time;
  changed_.notify_all();
}

void ScriptedBus::run_until(MonotonicTime time) {
  UniqueLock lock{mutex_};
  allowed_ = time;
  // The reader may still be on its way out of its last wait: only a later one counts.
  waits_for_more_ = false;
  changed_.notify_all();
  changed_.wait(lock.raw(), [this]() NACELLE_REQUIRES(mutex_) { return waits_for_more_; });
}

void ScriptedBus::fail(std::optional<StreamFault> fault) {
  const LockGuard lock{mutex_};
  fault_ = fault;
}

void ScriptedBus::lose_every(std::uint64_t n) {
  const LockGuard lock{mutex_};
  lose_every_ = n;
}

std::uint64_t ScriptedBus::transfers() const {
  const LockGuard lock{mutex_};
  return transfers_;
}

}  // namespace nacelle::io
