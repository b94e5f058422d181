// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pthread.h>

#include <atomic>
#include <ctime>
#include <thread>
#include <vector>

#include "nacelle/base/mutex.hpp"
#include "nacelle/runtime/executor.hpp"

namespace nacelle::runtime {

/// Checks the executors when a running callback becomes late or hangs. While callbacks return in time, its thread sleeps.
///
/// A timer of the kernel wakes it. An executor's thread that has slept and has something to run sets that timer, if it
/// is not set or a quarter of its time has passed: for handover_after later on the shared executor, for hang_after on
/// one of a single component. That is one system call in 5 ms at most, and wakes no thread. Only the due time of the
/// shared executor is put off in this way: when its one serving thread has slept, all its callbacks before that have
/// returned, or are known to be late.
///
/// If the kernel has no timer left, it checks once per handover_after. Threads: any.
class Supervisor {
 public:
  explicit Supervisor(Executor::Limits limits);
  ~Supervisor() { stop(); }
  void add(Executor& executor);
  void remove(Executor& executor);
  /// Stops checking all executors.
  void stop();
  /// Waits for a running check, which may be about to report a callback that has just returned.
  void settle() { const LockGuard lock(mutex_); }
  /// Returns how often its thread has checked the executors.
  [[nodiscard]] std::uint64_t checks() const { return checks_.load(std::memory_order_relaxed); }

 private:
  void watch();
  void check();
  void note_start(MonotonicTime now, bool is_shared);
  void set_timer() NACELLE_REQUIRES(due_mutex_);

  const Executor::Limits limits_;
  Mutex mutex_;
  std::vector<Executor*> executors_ NACELLE_GUARDED_BY(mutex_);
  std::atomic<std::uint64_t> checks_{0};
  std::atomic<bool> stopping_{false};

  FutexMutex due_mutex_;
  MonotonicTime handover_due_ NACELLE_GUARDED_BY(due_mutex_) = kNever;  // of callbacks that would be late
  MonotonicTime other_due_ NACELLE_GUARDED_BY(due_mutex_) = kNever;     // of those that would hang
  bool has_timer_ NACELLE_GUARDED_BY(due_mutex_) = false;
  timer_t timer_ NACELLE_GUARDED_BY(due_mutex_) = {};
  std::atomic<std::int64_t> due_ns_{kNever.since_origin.count()};  // the earlier one of the two
  std::thread thread_;
};

}  // namespace nacelle::runtime
