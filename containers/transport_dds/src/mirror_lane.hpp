// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace nacelle {

/// A thread for what may take as long as the network is slow. It is started with the first job; they are done in order.
/// Threads: any; stop() and the destructor one.
class MirrorLane {
 public:
  using Job = std::function<void()>;
  MirrorLane() = default;
  MirrorLane(const MirrorLane&) = delete;
  MirrorLane& operator=(const MirrorLane&) = delete;
  ~MirrorLane() { stop(); }

  void add(Job job);
  /// There is something to do, or being done.
  [[nodiscard]] bool is_busy() const;
  /// Waits for the job that is being done and drops the others.
  void stop();

 private:
  void run();

  mutable std::mutex mutex_;
  std::condition_variable woken_;
  std::deque<Job> jobs_;
  bool working_ = false, stopping_ = false;
  std::thread thread_;
};

}  // namespace nacelle
