// SPDX-License-Identifier: Apache-2.0
#include "errand.hpp"

#include <pthread.h>

#include <utility>

#include "nacelle/runtime/futex.hpp"

namespace nacelle::runtime {

Errand::Errand(const char* name, std::function<void()> what)
    : thread_([this, name, what = std::move(what)]() mutable {
        pthread_setname_np(pthread_self(), name);
        what();
        what = nullptr;
        ended_.store(1, std::memory_order_release);
        futex_wake(ended_, 1);
      }) {}

Errand::~Errand() { thread_.join(); }

bool Errand::wait(const Clock& clock, const Deadline& deadline) {
  while (!has_ended()) {
    const MonotonicTime now = clock.now(), end = deadline.now();
    if (now >= end) return false;
    deadline.note_waiting();
    futex_wait_until(clock, ended_, 0, end);
  }
  return true;
}

}  // namespace nacelle::runtime
