// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <string>

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

}  // namespace nacelle::test

/// The first line of a SetUp().
#define NACELLE_ONLY_IN_MACHINE(group) \
  if (!::nacelle::test::in_machine(group)) GTEST_SKIP() << "runs in a virtual machine only: ./dev vm " << (group)
