// SPDX-License-Identifier: Apache-2.0
#include "counting_allocator.hpp"

#include <cstdlib>
#include <new>

namespace {

thread_local nacelle::test::Allocated counted;

void* take(std::size_t bytes) {
  counted.bytes += bytes;
  ++counted.calls;
  if (void* const memory = std::malloc(bytes == 0 ? 1 : bytes)) return memory;
  throw std::bad_alloc{};
}

}  // namespace

namespace nacelle::test {
Allocated allocated() { return counted; }
}  // namespace nacelle::test

// Replaced for the whole program, message libraries included. The aligned forms are left: no message needs them.
void* operator new(std::size_t bytes) { return take(bytes); }
void* operator new[](std::size_t bytes) { return take(bytes); }
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  try {
    return take(bytes);
  } catch (const std::bad_alloc&) { return nullptr; }
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
