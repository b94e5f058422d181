// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>

#include "nacelle/runtime/executor.hpp"
#include "nacelle/runtime/thread.hpp"

namespace nacelle::runtime {

/// One thread of an executor. All but the word is under the executor's lock, or the thread's own.
struct Executor::Worker {
  enum class State : std::uint8_t {
    Awake,     // looks at the queue, or runs something
    Sleeping,  // has looked, and nothing was ready
    Called,    // was woken and will look
    Spare,     // does not serve; waits to take the place of a late one
  };
  Worker(Executor& e, bool is_first) : executor(e), first(is_first) {}

  Executor& executor;
  const bool first;  // it speaks for all: what one of them is refused, all are
  Thread thread;
  std::atomic<std::uint32_t> word{0};  // futex: moves with every call
  State state = State::Called;         // it will look as soon as it has started
  Executable* running = nullptr;       // null when it forgot itself; `group` says whether something runs
  CallbackGroup* group = nullptr;
  MonotonicTime started;
  // What is out of the ordinary with the run that goes on; nothing, as a rule.
  static constexpr std::uint8_t kAlone = 1,  // a transition
      kSampled = 2,                          // its CPU time is measured
      kLate = 4,                             // it has lost its place; when it returns the thread is a spare
      kReportedHung = 8;
  std::uint8_t unusual = 0;
  // The thread's own, for use outside the lock: what is to be done before the run.
  static constexpr std::uint8_t kHasRested = 1, kMeasured = 2;
  std::uint8_t special = 0;
  Duration cpu_before{}, cpu_used{};
  std::int32_t thread_id = 0;
  clockid_t cpu_clock = 0;  // readable from every thread; 0 until the thread has started

  // Whose thread this is, so that forget() from within a callback does not wait for itself.
  static thread_local Worker* here;
};

}  // namespace nacelle::runtime
