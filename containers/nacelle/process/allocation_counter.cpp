// SPDX-License-Identifier: Apache-2.0
// libnacelle_allocation_counter.so: preloaded (LD_PRELOAD) or linked, it counts the allocations of its process.
#include "process/allocation_counter.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <new>

namespace nacelle::process {
namespace {

struct Slot {
  std::atomic<int> tid{0};
  std::atomic<std::uint64_t> calls{0};
};

// Plain static memory: it is there before the first allocation, and a slot's thread is its only writer.
constinit std::array<Slot, kMaxCountedThreads> slots{};
constinit std::atomic<std::size_t> slots_used{0};
constinit std::atomic<std::uint64_t> uncounted{0};

// initial-exec: the first access from malloc must not itself allocate, as the lazy TLS models may.
__attribute__((tls_model("initial-exec"))) constinit thread_local Slot* my_slot = nullptr;
__attribute__((tls_model("initial-exec"))) constinit thread_local bool has_no_slot = false;

void count_call() noexcept {
  if (my_slot == nullptr) [[unlikely]] {
    if (has_no_slot) {
      uncounted.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    const std::size_t index = slots_used.fetch_add(1, std::memory_order_relaxed);
    if (index >= kMaxCountedThreads) {
      has_no_slot = true;
      uncounted.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    my_slot = &slots[index];
    my_slot->tid.store(static_cast<int>(::syscall(SYS_gettid)), std::memory_order_release);
  }
  // One writer: a load and a store cost less than a locked add.
  my_slot->calls.store(my_slot->calls.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

}  // namespace
}  // namespace nacelle::process

extern "C" void nacelle_take_allocation_snapshot(nacelle::process::AllocationSnapshot& out) {
  using namespace nacelle::process;
  out.count = 0;
  const std::size_t used = std::min(slots_used.load(std::memory_order_acquire), kMaxCountedThreads);
  for (std::size_t i = 0; i < used; ++i) {
    const int tid = slots[i].tid.load(std::memory_order_acquire);
    if (tid != 0) out.threads[out.count++] = {tid, slots[i].calls.load(std::memory_order_relaxed)};
  }
  out.uncounted = uncounted.load(std::memory_order_relaxed);
}

// The C library's own allocator under other names. Definitions of malloc and its kin in a library that stands before the C library
// are used by every library of the process, plugins included. Source: glibc, "Replacing malloc".
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT(bugprone-reserved-identifier)
void* __libc_calloc(std::size_t nmemb, std::size_t size);        // NOLINT(bugprone-reserved-identifier)
void* __libc_realloc(void* old, std::size_t size);               // NOLINT(bugprone-reserved-identifier)
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT(bugprone-reserved-identifier)

#define NACELLE_INTERPOSED __attribute__((visibility("default")))

NACELLE_INTERPOSED void* malloc(std::size_t size) noexcept {
  nacelle::process::count_call();
  return __libc_malloc(size);
}
NACELLE_INTERPOSED void* calloc(std::size_t nmemb, std::size_t size) noexcept {
  nacelle::process::count_call();
  return __libc_calloc(nmemb, size);
}
NACELLE_INTERPOSED void* realloc(void* ptr, std::size_t size) noexcept {
  nacelle::process::count_call();
  return __libc_realloc(ptr, size);
}
NACELLE_INTERPOSED void* memalign(std::size_t alignment, std::size_t size) noexcept {
  nacelle::process::count_call();
  return __libc_memalign(alignment, size);
}
NACELLE_INTERPOSED void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  nacelle::process::count_call();
  return __libc_memalign(alignment, size);
}
NACELLE_INTERPOSED int posix_memalign(void** memptr, std::size_t alignment, std::size_t size) noexcept {
  nacelle::process::count_call();
  if (alignment < sizeof(void*) || (alignment & (alignment - 1)) != 0) return EINVAL;
  const int before = errno;  // POSIX: the answer is the return value, errno stays
  void* const memory = __libc_memalign(alignment, size);
  errno = before;
  if (memory == nullptr) return ENOMEM;
  *memptr = memory;
  return 0;
}
}
