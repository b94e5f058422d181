// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

namespace nacelle::bench {

/// What one thread really executed between two marks, found by single-stepping it: the vDSO is in it (callgrind does not see
/// it), and so is every instruction with a bus lock.
struct Steps {
  std::uint64_t instructions = 0;
  std::uint64_t locked = 0;  ///< x86-64: a LOCK prefix, or XCHG with memory. AArch64: LSE atomics and exclusive loads.
  std::uint64_t syscalls = 0;
  std::uint64_t clock_reads = 0;  ///< Calls into the vDSO.
  bool ok = false;                ///< false: ptrace is not allowed here.
};

/// Forks; runs `work` in the child, which calls mark_steps() twice on one of its threads, and counts what that thread does in
/// between. Call it before the first thread is started.
[[nodiscard]] Steps count_steps(const std::function<void()>& work);

/// The beginning (first call) and the end (second call) of what is counted. Outside of count_steps() it does nothing.
void mark_steps();

}  // namespace nacelle::bench
