// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "nacelle/io/descriptor.hpp"

namespace nacelle::test {

/// Whether this program runs in the virtual machine of `./dev vm GROUP`. Elsewhere its tests skip themselves: they load, unbind and
/// unplug devices.
[[nodiscard]] inline bool in_machine(const std::string& group) {
  const char* const told = std::getenv("NACELLE_VM_GROUP");
  return told != nullptr && group == told;
}

/// Writes a file of sysfs or configfs in one piece. A refusal of the kernel is a failure of the test.
inline void write_file(const std::string& path, const std::string& text) {
  std::ofstream file{path};
  file << text << std::flush;
  EXPECT_TRUE(file) << path << " does not take '" << text << "'";
}

/// The first word of a file; empty if it cannot be read.
[[nodiscard]] inline std::string read_word(const std::string& path) {
  std::ifstream file{path};
  std::string word;
  file >> word;
  return word;
}

/// The longest that a test waits for something that is to come: it bounds a broken build only.
inline constexpr Duration kPatience = 60s;

/// Waits until `holds` is true; looks whenever an entry of the folder comes, goes, or changes its mode. Returns its last answer.
[[nodiscard]] inline bool wait_in_folder(const std::string& folder, const Clock& clock,
                                         const std::function<bool()>& holds) {
  const io::Descriptor watch{::inotify_init1(IN_CLOEXEC | IN_NONBLOCK)};
  EXPECT_GE(::inotify_add_watch(watch.number(), folder.c_str(), IN_CREATE | IN_DELETE | IN_ATTRIB), 0) << folder;
  Bell never;
  const MonotonicTime deadline = clock.now() + kPatience;
  while (!holds()) {
    if (io::wait_readable(watch.number(), never, clock, deadline) != io::Wake::Ready) return holds();
    std::array<char, 4096> events{};
    while (::read(watch.number(), events.data(), events.size()) > 0) {}
  }
  return true;
}
[[nodiscard]] inline bool wait_for_node(const std::string& path, const Clock& clock) {
  return wait_in_folder("/dev", clock, [&] { return std::filesystem::exists(path); });
}
[[nodiscard]] inline bool wait_for_no_node(const std::string& path, const Clock& clock) {
  return wait_in_folder("/dev", clock, [&] { return !std::filesystem::exists(path); });
}

/// Entries of /proc/self/fd or /proc/self/task: open files or threads.
[[nodiscard]] inline std::ptrdiff_t count_entries(const std::string& folder) {
  return std::distance(std::filesystem::directory_iterator{folder}, std::filesystem::directory_iterator{});
}

/// How many times a test pulls a cable: NACELLE_VM_CYCLES, or a few.
[[nodiscard]] inline int cycles() {
  const char* const told = std::getenv("NACELLE_VM_CYCLES");
  return told == nullptr ? 10 : std::atoi(told);
}

}  // namespace nacelle::test

/// The first line of a SetUp().
#define NACELLE_ONLY_IN_MACHINE(group) \
  if (!::nacelle::test::in_machine(group)) GTEST_SKIP() << "runs in a virtual machine only: ./dev vm " << (group)
