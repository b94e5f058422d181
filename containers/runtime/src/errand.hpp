// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <thread>

#include "nacelle/base/time.hpp"
#include "patience.hpp"

namespace nacelle::runtime {

/// Code of a component that no executor runs (a library's own start-up, a constructor, a destructor), on a thread of its own, so
/// that only whoever asked for it waits, and not longer than it wants to.
///
/// The thread ends with it: what a component keeps in thread-locals would pin its image for as long as the thread lives.
/// Threads: one owner; has_ended() from any.
class Errand {
 public:
  /// `name` is the thread's. `what` may run longer than its owner waits, so it owns what it uses; it is destroyed before the
  /// errand counts as ended, so the last owner of an errand must not be in it.
  Errand(const char* name, std::function<void()> what);
  /// Waits for the end.
  ~Errand();
  Errand(const Errand&) = delete;
  Errand& operator=(const Errand&) = delete;

  /// Returns false if it has not ended by the deadline; it goes on.
  [[nodiscard]] bool wait(const Clock& clock, const Deadline& deadline);
  [[nodiscard]] bool has_ended() const { return ended_.load(std::memory_order_acquire) != 0; }

 private:
  std::atomic<std::uint32_t> ended_{0};  // futex
  std::thread thread_;
};

}  // namespace nacelle::runtime
