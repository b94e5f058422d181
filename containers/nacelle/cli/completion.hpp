// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/command.hpp"

namespace nacelle::cli {

/// A word that may stand at the cursor.
struct Candidate {
  std::string word, what;  ///< what: a few words about it; may be empty.
  friend bool operator==(const Candidate&, const Candidate&) = default;
};

/// The sources for completing a name, in addition to the tree of commands.
struct NameQuestion {
  Names names = Names::Nothing;
  std::string container;                ///< The value of --container; empty: none.
  std::vector<std::string> positional;  ///< The positional words before this one.
};
/// Returns nothing if nothing is known; must not wait long.
using AskNames = std::function<std::vector<std::string>(const NameQuestion&)>;

/// Returns the completions of the last word (which may be empty) of a command line without the program's name. Returns
/// nothing for a file: the shell completes those. Pure except for `ask` and `containers`, which returns the running
/// ones.
[[nodiscard]] std::vector<Candidate> completions(const Command& root, std::vector<std::string> words,
                                                 const AskNames& ask,
                                                 const std::function<std::vector<std::string>()>& containers);

/// The function that a shell calls: "bash", "zsh" or "fish".
[[nodiscard]] const char* completion_script(const std::string& shell);

/// The names of an option one by one: "-t", "--times".
[[nodiscard]] std::vector<std::string> names_of(const Option& option);

}  // namespace nacelle::cli
