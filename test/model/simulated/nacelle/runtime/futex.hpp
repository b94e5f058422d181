// SPDX-License-Identifier: Apache-2.0
// Stands before the runtime's own header when its sources are compiled for the model check: the same words, simulated.
#pragma once

#include <atomic>
#include <cstdint>

#include "../../../scheduler.hpp"
#include "nacelle/base/thread_safety.hpp"

namespace nacelle::runtime {

inline void futex_wait_until(const std::atomic<std::uint32_t>& word, std::uint32_t expected, MonotonicTime deadline) {
  model::Scheduler::current().wait(word, expected, deadline);
}
inline void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected) {
  futex_wait_until(word, expected, model::kForEver);
}
inline void futex_wake(const std::atomic<std::uint32_t>& word, int count) {
  model::Scheduler::current().wake(word, count);
}

class NACELLE_CAPABILITY("mutex") FutexMutex {
 public:
  void lock() NACELLE_ACQUIRE() { model::Scheduler::current().lock(taken_); }
  void unlock() NACELLE_RELEASE() { model::Scheduler::current().unlock(taken_); }

 private:
  bool taken_ = false;
};

}  // namespace nacelle::runtime
