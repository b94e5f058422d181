// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <thread>
#include <vector>

#include "nacelle/base/mutex.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::lifecycle_manager {

/// Runs jobs in parallel for one caller. Threads: one caller at a time.
class Crew {
 public:
  virtual ~Crew() = default;
  /// Starts a job, which may end before start() returns. `work` must not throw.
  virtual void start(std::function<void()> work) = 0;
  /// Blocks until a job has ended since the last wait(), but not longer than `at_most`.
  virtual void wait(Duration at_most) = 0;
};

/// Runs each job on a thread of its own. Meant for a bring-up: the threads are joined by the destructor only, which
/// waits for all jobs.
class ThreadCrew final : public Crew {
 public:
  ThreadCrew() = default;
  ~ThreadCrew() override;
  ThreadCrew(const ThreadCrew&) = delete;
  ThreadCrew& operator=(const ThreadCrew&) = delete;

  void start(std::function<void()> work) override;
  void wait(Duration at_most) override;

 private:
  Mutex mutex_;
  std::condition_variable ended_;
  std::size_t count_ NACELLE_GUARDED_BY(mutex_) = 0;  // jobs that have ended
  std::size_t seen_ NACELLE_GUARDED_BY(mutex_) = 0;   // value of count_ at the end of the last wait()
  std::vector<std::thread> threads_;
};

}  // namespace nacelle::lifecycle_manager
