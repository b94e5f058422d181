// SPDX-License-Identifier: Apache-2.0
#include "process_counts.hpp"

#include <malloc.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

namespace nacelle::soak {
namespace {

namespace fs = std::filesystem;

std::size_t entries_of(const char* folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

// Without what the measurement itself holds open for a moment: this folder, and the neighbour's look at its threads' times.
std::size_t open_descriptors() {
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    const std::string target = fs::read_symlink(entry.path(), gone).string();
    if (!gone && !target.starts_with("/proc/")) ++count;
  }
  return count;
}

}  // namespace

ProcessCounts count_process() {
  ProcessCounts counts;
  const auto heap = ::mallinfo2();
  counts.heap_bytes = heap.uordblks + heap.hblkhd;
  counts.descriptors = open_descriptors();
  counts.threads = entries_of("/proc/self/task");
  std::ifstream rollup("/proc/self/smaps_rollup");
  for (std::string word; rollup >> word;) {
    if (word != "Rss:") continue;
    rollup >> counts.resident_bytes;
    counts.resident_bytes *= 1024;
    break;
  }
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    ++counts.mappings;
    const auto path = line.find('/');
    if (path != std::string::npos) ++counts.files[line.substr(path)];
  }
  return counts;
}

}  // namespace nacelle::soak
