// SPDX-License-Identifier: Apache-2.0
#include "process/attempt.hpp"

#include <array>
#include <cstdio>

namespace nacelle::process {

void say_failed(const char* what, const char* why) noexcept {
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), "nacelle: container: %s: %s", what, why);
  for (char& c : line) {
    if ((c > '\0' && c < ' ') || c == '\x7f') c = '?';
  }
  std::fprintf(stderr, "%s\n", line.data());
}

}  // namespace nacelle::process
