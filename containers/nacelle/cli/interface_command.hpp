// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

namespace CLI {
class App;
}

namespace nacelle::cli {

/// Where an installed or freshly built program finds the message packages' libraries: ../lib beside the program, and
/// ../lib/<architecture> where Debian puts them.
[[nodiscard]] std::vector<std::filesystem::path> message_library_directories();

/// Adds `interface list|show|hash|encode|decode` to the program's commands.
///
///   interface list [--package P] [--all]   type names, one a line
///   interface show TYPE                    the definition, with those it depends on
///   interface hash TYPE                    RIHS01_...
///   interface encode TYPE                  JSON on standard input -> CDR in hexadecimal, one line
///   interface decode TYPE                  CDR in hexadecimal on standard input -> JSON, one line
///
/// The commands run when `app` has parsed its arguments. `exit_code` is then 0, or 1 when a name or the input is wrong;
/// the reason is on standard error. Wrong arguments are CLI11's ParseError, as for every command.
void add_interface_command(CLI::App& app, int& exit_code,
                           std::vector<std::filesystem::path> library_directories = message_library_directories());

}  // namespace nacelle::cli
