// SPDX-License-Identifier: Apache-2.0
#include "allocation_guard.hpp"

#include <cstddef>

namespace {
thread_local std::uint64_t allocations = 0;
}

#ifndef NACELLE_SANITIZED
// glibc's own names of the functions below; operator new comes through malloc.
extern "C" {
// NOLINTBEGIN(bugprone-reserved-identifier): glibc's
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
// NOLINTEND(bugprone-reserved-identifier)

void* malloc(std::size_t n) {
  ++allocations;
  return __libc_malloc(n);
}
void* calloc(std::size_t n, std::size_t size) {
  ++allocations;
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t n) {
  ++allocations;
  return __libc_realloc(p, n);
}
void* aligned_alloc(std::size_t alignment, std::size_t n) {
  ++allocations;
  return __libc_memalign(alignment, n);
}
}
#endif

std::uint64_t nacelle::test::AllocationGuard::total() { return allocations; }
