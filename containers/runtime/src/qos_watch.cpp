// SPDX-License-Identifier: Apache-2.0
#include "qos_watch.hpp"

#include <pthread.h>

#include "nacelle/host/message.hpp"

namespace nacelle::runtime {

QosWatch::~QosWatch() {
  stopping_ = true;
  word_.fetch_add(1);
  futex_wake(word_, 1);
  if (thread_.joinable()) thread_.join();
}

void QosWatch::poke() {
  if (!running_.load(std::memory_order_acquire)) {
    const LockGuard lock(starting_);
    if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
    running_.store(true, std::memory_order_release);
  }
  word_.fetch_add(1);
  futex_wake(word_, 1);
}

void QosWatch::run() {
  pthread_setname_np(pthread_self(), "qos_watch");
  const SystemClock clock;
  while (!stopping_) {
    // Read before the check: changes during it are checked again.
    const std::uint32_t word = word_.load();
    const MonotonicTime again = look_(clock.now());
    if (again == kNeverExpires) {
      futex_wait(word_, word);
    } else {
      futex_wait_until(word_, word, again);
    }
  }
}

}  // namespace nacelle::runtime
