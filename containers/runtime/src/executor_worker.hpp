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
  bool late = false;                   // its callback has lost its place; when it returns it is a spare
  Executable* running = nullptr;       // null when it forgot itself; `group` says whether something runs
  CallbackGroup* group = nullptr;
  bool alone = false;  // a transition runs
  bool reported_hung = false;
  bool sampled = false;  // this run's CPU time is measured
  MonotonicTime started;
  Duration cpu_before{}, cpu_used{};
  std::int32_t thread_id = 0;
  clockid_t cpu_clock = 0;  // readable from every thread; 0 until the thread has started

  // Whose thread this is, so that forget() from within a callback does not wait for itself.
  static thread_local Worker* here;
};

}  // namespace nacelle::runtime
