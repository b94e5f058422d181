// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace nacelle::launch {

/// A text of a file as a message shows it: in one line, not long. Bytes of UTF-8 stay as they are.
[[nodiscard]] inline std::string shown(std::string_view text) {
  constexpr std::size_t kLongest = 80;
  std::string out;
  for (const char c : text.substr(0, kLongest)) {
    const bool is_control = static_cast<unsigned char>(c) < ' ' || c == 0x7f;
    out += is_control ? '?' : c;
  }
  return text.size() > kLongest ? out + "..." : out;
}

}  // namespace nacelle::launch
