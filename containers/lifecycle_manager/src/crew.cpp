// SPDX-License-Identifier: Apache-2.0
#include "nacelle/lifecycle_manager/crew.hpp"

#include <pthread.h>

#include <utility>

namespace nacelle::lifecycle_manager {

ThreadCrew::~ThreadCrew() {
  for (auto& thread : threads_) thread.join();
}

void ThreadCrew::start(std::function<void()> work) {
  threads_.emplace_back([this, work = std::move(work)] {
    pthread_setname_np(pthread_self(), "bring-up");
    work();
    const LockGuard lock(mutex_);
    ++count_;
    ended_.notify_one();
  });
}

void ThreadCrew::wait(Duration at_most) {
  UniqueLock lock(mutex_);
  ended_.wait_for(lock.raw(), at_most, [this]() NACELLE_REQUIRES(mutex_) { return count_ != seen_; });
  seen_ = count_;
}

}  // namespace nacelle::lifecycle_manager
