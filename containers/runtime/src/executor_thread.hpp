// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <ctime>
#include <string>

#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

/// A second stack for the thread that makes this: one that has overflown its own can still leave a record.
/// Executors' threads have one; a component's own threads leave no record of an overflow.
class SignalStack final {
 public:
  SignalStack();
  ~SignalStack();
  SignalStack(const SignalStack&) = delete;
  SignalStack& operator=(const SignalStack&) = delete;

 private:
  void* memory_ = nullptr;
};

/// Names this thread and gives it priority and CPUs; says what is refused if `complain`, and goes on without.
void prepare_this_thread(const std::string& name, const ThreadPolicy& policy, bool complain);
[[nodiscard]] std::int32_t this_thread_id();
/// Can be read from every thread while this one lives.
[[nodiscard]] clockid_t cpu_clock_of_this_thread();
/// A system call.
[[nodiscard]] Duration cpu_time_of(clockid_t clock);

}  // namespace nacelle::runtime
