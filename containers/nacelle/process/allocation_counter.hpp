// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace nacelle::process {

/// The number of allocations of one thread so far: calls of malloc, calloc, realloc, aligned_alloc, memalign and
/// posix_memalign. operator new calls one of them.
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

/// Returns whether libnacelle_allocation_counter.so is in the process, preloaded or linked. Builds with a sanitizer
/// have no such library.
[[nodiscard]] bool allocations_are_counted();
/// Writes the present counts; without the library, none. A thread appears with its first allocation and stays after its
/// end.
/// Threads: any. Allocates: nothing, after the first call.
void take_snapshot(AllocationSnapshot& out);

}  // namespace nacelle::process

/// Implements take_snapshot() in the library.
extern "C" void nacelle_take_allocation_snapshot(nacelle::process::AllocationSnapshot& out);
