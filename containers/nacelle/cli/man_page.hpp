// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "cli/command.hpp"

namespace nacelle::cli {

/// Returns the manual page of the whole program, in the man(7) macros. Pure: the same tree gives the same page.
[[nodiscard]] std::string man_page(const Command& root, const std::string& version);

/// Escapes a text for roff: no character acts as a request or an escape, and a dash can be copied into a shell.
[[nodiscard]] std::string roff(const std::string& text);

}  // namespace nacelle::cli
