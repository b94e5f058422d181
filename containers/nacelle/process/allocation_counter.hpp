// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace nacelle::process {

/// Calls of malloc, calloc, realloc, aligned_alloc and their kin (operator new calls one of them) of one thread so far.
struct ThreadAllocations {
  int tid = 0;
  std::uint64_t calls = 0;
};

inline constexpr std::size_t kMaxCountedThreads = 512;

struct AllocationSnapshot {
  std::array<ThreadAllocations, kMaxCountedThreads> threads;
  std::size_t count = 0;
  std::uint64_t uncounted = 0;  ///< Calls of threads beyond the table's size.
};

/// Returns whether libnacelle_allocation_counter.so is in the process, preloaded or linked. Sanitizers' builds have no such library.
[[nodiscard]] bool allocations_are_counted();
/// Writes the counts now; none without the library. A thread appears with its first allocation, and stays after its end.
/// Threads: any. Allocates: nothing, after the first call.
void take_snapshot(AllocationSnapshot& out);

}  // namespace nacelle::process

/// The library's own function.
extern "C" void nacelle_take_allocation_snapshot(nacelle::process::AllocationSnapshot& out);
