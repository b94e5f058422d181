// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace nacelle::soak {

/// What a process has, as the kernel counts it.
struct ProcessCounts {
  std::size_t resident_bytes = 0;  ///< Exact (smaps_rollup), not the sloppy sum of statm.
  std::size_t heap_bytes = 0;      ///< What malloc has given out and not got back.
  std::size_t mappings = 0, descriptors = 0, threads = 0;
  std::map<std::string, std::size_t> files;  ///< Mapped files, with the number of their mappings.
};

[[nodiscard]] ProcessCounts count_process();

}  // namespace nacelle::soak
