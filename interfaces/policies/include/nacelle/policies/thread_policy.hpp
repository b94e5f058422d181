// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace nacelle {

/// Which thread runs a component's callbacks.
struct ThreadPolicy {
  bool own = false;           ///< false: the container's shared executor, which has one thread.
  int priority = 0;           ///< 1 to 99 asks for SCHED_FIFO; refused with a warning where not allowed.
  std::vector<int> cpus;      ///< Empty: any.
  std::uint32_t threads = 1;  ///< Of one's own, 1 to 64: more than one lets callback groups run at the same time.
  friend bool operator==(const ThreadPolicy&, const ThreadPolicy&) = default;
};

}  // namespace nacelle
