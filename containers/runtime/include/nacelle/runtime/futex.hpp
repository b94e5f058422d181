// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "nacelle/base/thread_safety.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::runtime {

/// Sleeps while `word` holds `expected`, until woken or the deadline. May return spuriously: check again.
void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected);
void futex_wait_until(const std::atomic<std::uint32_t>& word, std::uint32_t expected, MonotonicTime deadline);
/// The same with a clock that may be a test's and unknown to the kernel: it is read every 20 ms. For rare waits.
void futex_wait_until(const Clock& clock, const std::atomic<std::uint32_t>& word, std::uint32_t expected,
                      MonotonicTime deadline);
void futex_wake(const std::atomic<std::uint32_t>& word, int count);

/// A mutex of four bytes whose uncontended pair costs two atomic instructions.
///
/// For the short sections of the message path. A plain spin lock would deadlock two priorities on one CPU; this one
/// sleeps.
/// Source: U. Drepper, "Futexes are tricky", mutex 2. Threads: any.
class NACELLE_CAPABILITY("mutex") FutexMutex {
 public:
  void lock() NACELLE_ACQUIRE() {
    std::uint32_t expected = kFree;
    if (!state_.compare_exchange_strong(expected, kTaken, std::memory_order_acquire)) [[unlikely]]
      lock_slowly();
  }
  void unlock() NACELLE_RELEASE() {
    if (state_.exchange(kFree, std::memory_order_release) == kContended) [[unlikely]]
      futex_wake(state_, 1);
  }
  bool try_lock() NACELLE_TRY_ACQUIRE(true) {
    std::uint32_t expected = kFree;
    return state_.compare_exchange_strong(expected, kTaken, std::memory_order_acquire);
  }

 private:
  static constexpr std::uint32_t kFree = 0, kTaken = 1, kContended = 2;
  void lock_slowly();

  std::atomic<std::uint32_t> state_{kFree};
};

}  // namespace nacelle::runtime
