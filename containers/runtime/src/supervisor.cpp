// SPDX-License-Identifier: Apache-2.0
#include "supervisor.hpp"

#include <pthread.h>

#include <algorithm>

namespace nacelle::runtime {

Supervisor::Supervisor(Executor::Limits limits) : limits_(limits), thread_([this] { watch(); }) {}

void Supervisor::stop() {
  stopping_ = true;
  wake();
  if (thread_.joinable()) thread_.join();
}

void Supervisor::add(Executor& executor) {
  executor.set_activity_hook([this] {
    if (parked_.load()) wake();
  });
  {
    const LockGuard lock(mutex_);
    executors_.push_back(&executor);
  }
  wake();
}

void Supervisor::remove(Executor& executor) {
  const LockGuard lock(mutex_);
  std::erase(executors_, &executor);
}

void Supervisor::wake() {
  parked_ = false;
  word_.fetch_add(1);
  futex_wake(word_, 1);
}

bool Supervisor::has_stalled() {
  const std::uint32_t checks = checks_.load();
  const bool stalled = checks_seen_ == checks;
  checks_seen_ = checks;
  // Not wake(): the container is as idle as before, and the thread may rest again after one check.
  word_.fetch_add(1);
  futex_wake(word_, 1);
  return stalled;
}

void Supervisor::watch() {
  pthread_setname_np(pthread_self(), "supervisor");
  const SystemClock clock;  // it watches real threads, so it uses real time
  // A callback that starts just after a check has run for less than this at the next one, which returns when it will be
  // late.
  const Duration period = limits_.handover_after;
  const auto idle_looks_before_rest = std::max<Duration::rep>(1, 1s / period);
  Duration::rep idle_looks = 0;
  while (!stopping_) {
    const std::uint32_t word = word_.load();
    // Before the check: an executor that starts to run after its check finds this set, and wakes the supervisor.
    const bool to_rest = idle_looks >= idle_looks_before_rest;
    parked_ = to_rest;
    bool idle = true;
    Duration next = period;
    {
      const LockGuard lock(mutex_);
      for (Executor* executor : executors_) {
        next = std::min(next, executor->supervise(limits_));
        idle = idle && executor->is_idle();
      }
    }
    idle_looks = idle ? idle_looks + 1 : 0;
    checks_.fetch_add(1);
    if (to_rest && idle) {
      futex_wait(word_, word);
      if (!parked_.load()) idle_looks = 0;  // an executor has something to run
    } else {
      futex_wait_until(word_, word, clock.now() + std::max<Duration>(next, 1ms));
    }
    parked_ = false;
  }
}

}  // namespace nacelle::runtime
