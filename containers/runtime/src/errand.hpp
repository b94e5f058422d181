// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <thread>

#include "nacelle/base/time.hpp"
#include "patience.hpp"

namespace nacelle::runtime {

/// Runs component code that belongs to no executor (a library's start-up code, a constructor, a destructor) on its own
/// thread, so that only the requester waits, and with a time limit.
///
/// The thread ends afterwards: a component's thread-locals would otherwise pin its image for as long as the thread
/// exists.
/// Threads: one owner; has_ended() from any.
class Errand {
 public:
  /// `name` is the thread's. `what` may run longer than its owner waits, so it must own everything that it uses. It is
  /// destroyed before the errand counts as ended, so it must not hold the last reference to an errand.
  Errand(const char* name, std::function<void()> what);
  /// Waits for the end.
  ~Errand();
  Errand(const Errand&) = delete;
  Errand& operator=(const Errand&) = delete;

  /// Returns false if it has not ended by the deadline; it keeps running.
  [[nodiscard]] bool wait(const Clock& clock, const Deadline& deadline);
  [[nodiscard]] bool has_ended() const { return ended_.load(std::memory_order_acquire) != 0; }

 private:
  std::atomic<std::uint32_t> ended_{0};  // futex
  std::thread thread_;
};

}  // namespace nacelle::runtime
