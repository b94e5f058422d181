// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>

#include "nacelle/runtime/executor.hpp"
#include "nacelle/runtime/thread.hpp"

namespace nacelle::runtime {

/// One thread of an executor. All members but `word` are guarded by the executor's lock, or used by the thread only.
struct Executor::Worker {
  enum class State : std::uint8_t {
    Awake,     // reads the queue, or runs something
    Sleeping,  // has read the queue, and nothing was ready
    Called,    // was woken and will read the queue
    Spare,     // does not serve; waits to replace a late thread
  };
  Worker(Executor& e, bool is_first) : executor(e), first(is_first) {}

  Executor& executor;
  const bool first;  // logs refusals for all threads: they all get the same
  Thread thread;
  std::atomic<std::uint32_t> word{0};  // futex: changes with every call
  State state = State::Called;         // it reads the queue as soon as it has started
  Executable* running = nullptr;       // null if it removed itself; `group` shows whether something runs
  CallbackGroup* group = nullptr;
  MonotonicTime started;
  // Special properties of the current run; usually none.
  static constexpr std::uint8_t kAlone = 1,  // a transition
      kSampled = 2,                          // its CPU time is measured
      kLate = 4,                             // another thread has taken over; after its return this thread is a spare
      kReportedHung = 8;
  std::uint8_t unusual = 0;
  // The thread's own, for use outside the lock: work to do before the run.
  static constexpr std::uint8_t kHasRested = 1, kMeasured = 2;
  std::uint8_t special = 0;
  Duration cpu_before{}, cpu_used{};
  std::int32_t thread_id = 0;
  clockid_t cpu_clock = 0;  // readable from every thread; 0 until the thread has started

  // The worker of the calling thread, or null. With it forget() does not wait for the callback that calls it.
  static thread_local Worker* here;
};

}  // namespace nacelle::runtime
