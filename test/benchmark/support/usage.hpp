// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nacelle/base/time.hpp"

namespace nacelle::bench {

/// What the whole process has used so far; two of them and a difference make a figure.
/// Threads: any. Allocates: nothing.
struct Usage {
  std::uint64_t mallocs = 0;   ///< malloc and kin, operator new, of all threads.
  std::uint64_t faults = 0;    ///< Page faults, minor and major.
  std::uint64_t switches = 0;  ///< Context switches, voluntary and not.
  Duration cpu{};              ///< User and system time.
  MonotonicTime at;

  [[nodiscard]] static Usage now();
  friend Usage operator-(const Usage& a, const Usage& b) {
    return {a.mallocs - b.mallocs, a.faults - b.faults, a.switches - b.switches, a.cpu - b.cpu,
            MonotonicTime{a.at - b.at}};
  }
};

/// Bytes of this process in memory, as /proc/self/status says: all of them, and those that no file backs.
struct Memory {
  std::uint64_t resident = 0, anonymous = 0;
  std::uint64_t proportional = 0;  ///< PSS, of those programs that ask for it.
  [[nodiscard]] static Memory now();
};

}  // namespace nacelle::bench
