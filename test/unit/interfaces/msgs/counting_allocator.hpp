// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace nacelle::test {

/// What this thread has asked operator new for so far, in bytes and calls.
struct Allocated {
  std::size_t bytes = 0;
  std::size_t calls = 0;
};
[[nodiscard]] Allocated allocated();

}  // namespace nacelle::test
