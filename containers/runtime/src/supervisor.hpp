// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <optional>
#include <thread>
#include <vector>

#include "nacelle/base/mutex.hpp"
#include "nacelle/runtime/executor.hpp"

namespace nacelle::runtime {

/// Checks the executors once per handover_after, and when a running callback becomes late. Sleeps without a deadline
/// when all executors have been idle for a second, so that an idle robot costs no wake-ups. Threads: any.
class Supervisor {
 public:
  explicit Supervisor(Executor::Limits limits);
  ~Supervisor() { stop(); }
  void add(Executor& executor);
  void remove(Executor& executor);
  /// Stops checking all executors.
  void stop();
  /// Returns true if no check has ended since the last call. Wakes the thread, so that even an idle container is checked before
  /// the next call. Threads: one.
  [[nodiscard]] bool has_stalled();
  /// Waits for a running check, which may be about to report a callback that has just returned.
  void settle() { const LockGuard lock(mutex_); }

 private:
  void watch();
  void wake();

  const Executor::Limits limits_;
  Mutex mutex_;
  std::vector<Executor*> executors_ NACELLE_GUARDED_BY(mutex_);
  std::atomic<bool> parked_{false};
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint32_t> word_{0}, checks_{0};
  std::optional<std::uint32_t> checks_seen_;  // at the last call of has_stalled()
  std::thread thread_;
};

}  // namespace nacelle::runtime
