// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utf8cpp/utf8/unchecked.h>

#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>

namespace nacelle::msgs {

/// Returns the text as UTF-8. An unpaired surrogate becomes U+FFFD.
[[nodiscard]] inline std::string utf8_of(std::u16string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::uint32_t c = text[i];
    if (c >= 0xD800 && c < 0xE000) {
      const bool pair = c < 0xDC00 && i + 1 < text.size() && text[i + 1] >= 0xDC00 && text[i + 1] < 0xE000;
      c = pair ? 0x10000 + ((c - 0xD800) << 10) + (static_cast<std::uint32_t>(text[++i]) - 0xDC00) : 0xFFFD;
    }
    utf8::unchecked::append(c, std::back_inserter(out));
  }
  return out;
}

/// Returns the text as UTF-16. What is not UTF-8 becomes U+FFFD.
[[nodiscard]] inline std::u16string utf16_of(std::string_view text) {
  std::string valid;
  utf8::unchecked::replace_invalid(text.begin(), text.end(), std::back_inserter(valid));
  std::u16string out;
  utf8::unchecked::utf8to16(valid.begin(), valid.end(), std::back_inserter(out));
  return out;
}

}  // namespace nacelle::msgs
