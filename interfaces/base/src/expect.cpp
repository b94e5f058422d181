// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/expect.hpp"

#include <cstdio>
#include <cstdlib>

namespace nacelle::detail {

void expectation_failed(const char* file, int line, const char* condition, const char* why) {
  std::fprintf(stderr, "%s:%d: %s (expected: %s)\n", file, line, why, condition);
  std::abort();
}

}  // namespace nacelle::detail
