// SPDX-License-Identifier: Apache-2.0
#include "supervisor.hpp"

#include <pthread.h>

#include <algorithm>

namespace nacelle::runtime {

Supervisor::Supervisor(Executor::Limits limits) : limits_(limits), thread_([this] { watch(); }) {}

Supervisor::~Supervisor() {
  stopping_ = true;
  wake();
  thread_.join();
}

void Supervisor::add(Executor& executor) {
  executor.set_activity_hook([this] {
    if (parked_.load(std::memory_order_relaxed)) wake();
  });
  {
    const std::lock_guard lock(mutex_);
    executors_.push_back(&executor);
  }
  wake();
}

void Supervisor::remove(Executor& executor) {
  const std::lock_guard lock(mutex_);
  std::erase(executors_, &executor);
}

void Supervisor::wake() {
  parked_ = false;
  word_.fetch_add(1);
  futex_wake(word_, 1);
}

void Supervisor::watch() {
  pthread_setname_np(pthread_self(), "supervisor");
  const SystemClock clock;  // real threads are watched, so real time it is
  const Duration period = limits_.handover_after / 2;
  const auto idle_looks_before_rest = std::max<Duration::rep>(1, 1s / period);
  Duration::rep idle_looks = 0;
  while (!stopping_) {
    const std::uint32_t word = word_.load();
    bool idle = true;
    {
      const std::lock_guard lock(mutex_);
      for (Executor* executor : executors_) {
        executor->supervise(limits_);
        idle = idle && executor->is_idle();
      }
    }
    idle_looks = idle ? idle_looks + 1 : 0;
    if (idle_looks >= idle_looks_before_rest) {
      parked_ = true;
      futex_wait(word_, word);
      parked_ = false;
      idle_looks = 0;
    } else {
      futex_wait_until(word_, word, clock.now() + period);
    }
  }
}

}  // namespace nacelle::runtime
