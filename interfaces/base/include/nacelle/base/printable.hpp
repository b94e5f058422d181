// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace nacelle {

/// Returns the text as a terminal may get it: a control character other than tab and line end becomes "\x1b", so that text from
/// outside can neither move the cursor nor hide what was printed before. Problem::text() is made of it.
[[nodiscard]] std::string printable(std::string_view text);

/// Returns the text as one line, for names: tabs and line ends become "\x09" and "\x0a", too.
[[nodiscard]] std::string printable_line(std::string_view text);

/// Returns the text as one entry of a log: each line after the first begins with "  | ", so that no text from outside can pass for
/// an entry of its own. Line ends at the end of the text are left out.
[[nodiscard]] std::string printable_entry(std::string_view text);

/// Returns how many bytes the control character at `at` has: 1, 2 for U+0080 to U+009F in UTF-8 (U+009B begins a sequence as ESC [
/// does), 0 if no control character stands there. The last of them is its number. Allocates: nothing.
[[nodiscard]] std::size_t control_bytes(std::string_view text, std::size_t at);

/// Returns whether all three return the text as it is. Allocates: nothing.
[[nodiscard]] bool is_printable_line(std::string_view text);

}  // namespace nacelle
