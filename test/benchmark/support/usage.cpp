// SPDX-License-Identifier: Apache-2.0
#include "support/usage.hpp"

#include <sys/resource.h>

#include <cstdio>

#include "nacelle/base/expect.hpp"
#include "process/allocation_counter.hpp"

namespace nacelle::bench {
namespace {

Duration to_duration(const timeval& t) { return std::chrono::seconds(t.tv_sec) + std::chrono::microseconds(t.tv_usec); }

}  // namespace

Usage Usage::now() {
  NACELLE_EXPECT(process::allocations_are_counted(), "a benchmark is linked with the library that counts allocations");
  static thread_local process::AllocationSnapshot snapshot;
  process::take_snapshot(snapshot);
  Usage usage;
  usage.mallocs = snapshot.uncounted;
  for (std::size_t i = 0; i < snapshot.count; ++i) usage.mallocs += snapshot.threads[i].calls;
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  usage.faults = static_cast<std::uint64_t>(used.ru_minflt) + static_cast<std::uint64_t>(used.ru_majflt);
  usage.switches = static_cast<std::uint64_t>(used.ru_nvcsw) + static_cast<std::uint64_t>(used.ru_nivcsw);
  usage.cpu = to_duration(used.ru_utime) + to_duration(used.ru_stime);
  usage.at = SystemClock{}.now();
  return usage;
}

Memory Memory::now() {
  Memory memory;
  std::FILE* const file = std::fopen("/proc/self/status", "r");
  if (file == nullptr) return memory;
  char line[256];
  unsigned long long kilobytes = 0;
  while (std::fgets(line, sizeof line, file) != nullptr) {
    if (std::sscanf(line, "VmRSS: %llu", &kilobytes) == 1) memory.resident = kilobytes * 1024;
    if (std::sscanf(line, "RssAnon: %llu", &kilobytes) == 1) memory.anonymous = kilobytes * 1024;
  }
  std::fclose(file);
  return memory;
}

}  // namespace nacelle::bench
