// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <thread>

#include "nacelle/base/mutex.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/runtime/futex.hpp"

namespace nacelle::runtime {

/// Checks deadlines and leases when they are due, on a thread that exists from the first poke() on and sleeps in
/// between. MonotonicTime is always that of CLOCK_MONOTONIC here.
class QosWatch {
 public:
  /// `look` receives the time and returns the latest time of the next check.
  explicit QosWatch(std::function<MonotonicTime(MonotonicTime)> look) : look_(std::move(look)) {}
  ~QosWatch();
  QosWatch(const QosWatch&) = delete;
  QosWatch& operator=(const QosWatch&) = delete;

  /// Wakes the thread for a check earlier than the last one returned. Threads: any; locks may be held.
  void poke();

 private:
  void run();

  const std::function<MonotonicTime(MonotonicTime)> look_;
  std::atomic<std::uint32_t> word_{0};
  std::atomic<bool> stopping_{false}, running_{false};
  Mutex starting_;
  std::thread thread_ NACELLE_GUARDED_BY(starting_);
};

}  // namespace nacelle::runtime
