// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

#include "nacelle/runtime/executor.hpp"

namespace nacelle::runtime {

/// Looks at the executors twice per handover_after while callbacks run, and sleeps without a deadline when all have been idle
/// for a second: an idle robot costs no wake-up. Threads: any.
class Supervisor {
 public:
  explicit Supervisor(Executor::Limits limits);
  ~Supervisor() { stop(); }
  void add(Executor& executor);
  void remove(Executor& executor);
  /// Nobody is looked at any more.
  void stop();
  /// Returns when a look that is under way has ended: it may be about to report a callback that has just returned.
  void settle() { const std::lock_guard lock(mutex_); }

 private:
  void watch();
  void wake();

  const Executor::Limits limits_;
  std::mutex mutex_;
  std::vector<Executor*> executors_;
  std::atomic<bool> parked_{false};
  std::atomic<bool> stopping_{false};
  std::atomic<std::uint32_t> word_{0};
  std::thread thread_;
};

}  // namespace nacelle::runtime
