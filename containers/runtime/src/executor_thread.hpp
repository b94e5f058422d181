// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <ctime>
#include <string>

#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

/// A second stack for the constructing thread, so that a thread whose own stack overflowed can still write a crash
/// record. For threads of executors and the thread of the CrashHandler; other threads get theirs from the thread guard
/// (thread_guard.hpp).
class SignalStack final {
 public:
  SignalStack();
  ~SignalStack();
  SignalStack(const SignalStack&) = delete;
  SignalStack& operator=(const SignalStack&) = delete;

 private:
  void* memory_ = nullptr;
};

/// Sets the name, priority and CPUs of this thread. If the kernel refuses a setting, it stays as it was, and a warning
/// is logged if `complain`.
void prepare_this_thread(const std::string& name, const ThreadPolicy& policy, bool complain);
[[nodiscard]] std::int32_t this_thread_id();
/// Returns the CPU clock of this thread. Any thread can read it while this one exists.
[[nodiscard]] clockid_t cpu_clock_of_this_thread();
/// Reads a CPU clock, which is a system call.
[[nodiscard]] Duration cpu_time_of(clockid_t clock);

}  // namespace nacelle::runtime
