// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <thread>
#include <vector>

#include "nacelle/base/mutex.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::lifecycle_manager {

/// Does several pieces of work beside each other for one caller.
class Crew {
 public:
  virtual ~Crew() = default;
  /// `work` does not throw. It may be done before start() returns.
  virtual void start(std::function<void()> work) = 0;
  /// Returns when a piece of work has ended since the last wait(), or after `at_most`.
  virtual void wait(Duration at_most) = 0;
};

/// A thread for each piece of work; for a bring-up, not for a steady state. Its destructor waits for all of them.
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
  std::size_t count_ NACELLE_GUARDED_BY(mutex_) = 0;  // pieces that have ended ...
  std::size_t seen_ NACELLE_GUARDED_BY(mutex_) = 0;   // ... and of them those that a wait() knew of
  std::vector<std::thread> threads_;
};

}  // namespace nacelle::lifecycle_manager
