// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <thread>

#include "nacelle/base/time.hpp"
#include "nacelle/runtime/futex.hpp"

namespace nacelle::runtime {

/// Looks at what time breaks (deadlines, leases) when it is due, on a thread that exists from the first poke() on and sleeps in between.
/// Real threads, so real time: MonotonicTime is CLOCK_MONOTONIC's here.
class Watchdog {
 public:
  /// `look` gets the time and returns when to look again at the latest.
  explicit Watchdog(std::function<MonotonicTime(MonotonicTime)> look) : look_(std::move(look)) {}
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// There is something to look at earlier than the last look has said. Threads: any; locks may be held.
  void poke();

 private:
  void run();

  const std::function<MonotonicTime(MonotonicTime)> look_;
  std::atomic<std::uint32_t> word_{0};
  std::atomic<bool> stopping_{false}, running_{false};
  std::mutex starting_;
  std::thread thread_;
};

}  // namespace nacelle::runtime
