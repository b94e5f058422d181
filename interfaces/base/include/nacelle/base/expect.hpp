// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle::detail {
[[noreturn]] void expectation_failed(const char* file, int line, const char* condition, const char* why);
}  // namespace nacelle::detail

/// Stops the process on a bug of the programmer, never on bad input. `why` says what the code needs.
#define NACELLE_EXPECT(condition, why)                                            \
  do {                                                                            \
    if (!(condition)) [[unlikely]]                                                \
      ::nacelle::detail::expectation_failed(__FILE__, __LINE__, #condition, why); \
  } while (false)
