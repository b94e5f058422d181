// SPDX-License-Identifier: Apache-2.0
#include "process_counts.hpp"

#include <malloc.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace nacelle::soak {
namespace {

std::size_t entries_of(const char* folder) {
  namespace fs = std::filesystem;
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

}  // namespace

ProcessCounts count_process() {
  ProcessCounts counts;
  const auto heap = ::mallinfo2();
  counts.heap_bytes = heap.uordblks + heap.hblkhd;
  counts.descriptors = entries_of("/proc/self/fd") - 1;  // without the one that looks
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
