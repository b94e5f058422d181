// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::test {

/// Counts what this thread takes from the heap (malloc, calloc, realloc, aligned_alloc, operator new) while it lives.
///
/// Under a sanitizer, which has a heap of its own, it counts nothing.
class AllocationGuard {
 public:
  AllocationGuard() : before_(total()) {}
  [[nodiscard]] std::uint64_t count() const { return total() - before_; }

 private:
  static std::uint64_t total();
  const std::uint64_t before_;
};

}  // namespace nacelle::test
