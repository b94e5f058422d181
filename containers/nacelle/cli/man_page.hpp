// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "cli/command.hpp"

namespace nacelle::cli {

/// The manual page of the whole program, in the man(7) macros. Pure: the same tree gives the same page.
[[nodiscard]] std::string man_page(const Command& root, const std::string& version);

/// Text as roff takes it: no letter of it is a request or an escape, and a dash can be copied into a shell.
[[nodiscard]] std::string roff(const std::string& text);

}  // namespace nacelle::cli
