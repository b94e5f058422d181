// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <thread>

#include "nacelle/base/mutex.hpp"

namespace nacelle {

/// A thread for sends that may take long on a slow network. It is started with the first job; jobs run in order.
/// Threads: any; stop() and the destructor one.
class MirrorLane {
 public:
  using Job = std::function<void()>;
  MirrorLane() = default;
  MirrorLane(const MirrorLane&) = delete;
  MirrorLane& operator=(const MirrorLane&) = delete;
  ~MirrorLane() { stop(); }

  void add(Job job);
  /// Returns true while a job is waiting or running.
  [[nodiscard]] bool is_busy() const;
  /// Waits for the running job and drops the others.
  void stop();

 private:
  void run();

  mutable Mutex mutex_;
  std::condition_variable woken_;
  std::deque<Job> jobs_ NACELLE_GUARDED_BY(mutex_);
  bool working_ NACELLE_GUARDED_BY(mutex_) = false, stopping_ NACELLE_GUARDED_BY(mutex_) = false;
  std::thread thread_ NACELLE_GUARDED_BY(mutex_);
};

}  // namespace nacelle
