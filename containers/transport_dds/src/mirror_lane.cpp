// SPDX-License-Identifier: Apache-2.0
#include "mirror_lane.hpp"

#include <pthread.h>

#include <utility>

namespace nacelle {

void MirrorLane::add(Job job) {
  const LockGuard lock(mutex_);
  jobs_.push_back(std::move(job));
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
  woken_.notify_one();
}

bool MirrorLane::is_busy() const {
  const LockGuard lock(mutex_);
  return working_ || !jobs_.empty();
}

void MirrorLane::stop() {
  std::deque<Job> dropped;
  std::thread thread;
  {
    const LockGuard lock(mutex_);
    stopping_ = true;
    std::swap(dropped, jobs_);
    std::swap(thread, thread_);
  }
  woken_.notify_one();
  if (thread.joinable()) thread.join();
}

void MirrorLane::run() {
  pthread_setname_np(pthread_self(), "network large");
  UniqueLock lock(mutex_);
  for (;;) {
    woken_.wait(lock.raw(), [this]() NACELLE_REQUIRES(mutex_) { return stopping_ || !jobs_.empty(); });
    if (stopping_) return;
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    working_ = true;
    lock.unlock();
    job();
    job = nullptr;  // destroys what the job owns
    lock.lock();
    working_ = false;
  }
}

}  // namespace nacelle
