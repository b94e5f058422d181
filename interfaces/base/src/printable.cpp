// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/printable.hpp"

namespace nacelle {
namespace {

enum class Blanks { Kept, Escaped };  // tabs and line ends

std::string escaped(std::string_view text, Blanks blanks, std::string_view after_line_end = "") {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string all;
  all.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t bytes = control_bytes(text, at);
    const bool is_kept = bytes == 0 || (blanks == Blanks::Kept && (text[at] == '\n' || text[at] == '\t'));
    if (is_kept) {
      all += text[at];
      if (text[at] == '\n') all += after_line_end;
      ++at;
      continue;
    }
    for (const std::size_t end = at + bytes; at < end; ++at) {
      const auto code = static_cast<unsigned char>(text[at]);
      ((all += "\\x") += kDigits[code >> 4U]) += kDigits[code & 15U];
    }
  }
  return all;
}

}  // namespace

std::size_t control_bytes(std::string_view text, std::size_t at) {
  const auto byte = static_cast<unsigned char>(text[at]);
  if (byte < 0x20 || byte == 0x7F) return 1;
  // C2 80 to C2 9F.
  const bool is_c1 = byte == 0xC2 && at + 1 < text.size() && (static_cast<unsigned char>(text[at + 1]) & 0xE0U) == 0x80;
  return is_c1 ? 2 : 0;
}

std::string printable(std::string_view text) { return escaped(text, Blanks::Kept); }

std::string printable_line(std::string_view text) { return escaped(text, Blanks::Escaped); }

std::string printable_entry(std::string_view text) {
  return escaped(text.substr(0, text.find_last_not_of('\n') + 1), Blanks::Kept, "  | ");
}

bool is_printable_line(std::string_view text) {
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (control_bytes(text, at) != 0) return false;
  }
  return true;
}

}  // namespace nacelle
