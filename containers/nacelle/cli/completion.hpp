// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/command.hpp"

namespace nacelle::cli {

/// A possible completion of the word at the cursor.
struct Candidate {
  std::string word, what;  ///< what: a short description; may be empty.
  friend bool operator==(const Candidate&, const Candidate&) = default;
};

/// A name to complete, and the words that limit the choice.
struct NameQuestion {
  Names names = Names::Nothing;
  std::string container;                ///< The value of --container; empty: none.
  std::vector<std::string> positional;  ///< The positional words before this one.
};
/// Returns the candidates, or nothing if they are unknown. It must answer quickly, because the shell blocks.
using AskNames = std::function<std::vector<std::string>(const NameQuestion&)>;

/// Returns the completions of the last word (which may be empty) of a command line without the program's name. Returns
/// nothing for a file, which the shell completes. `containers` returns the running containers. Pure except for `ask`
/// and `containers`.
[[nodiscard]] std::vector<Candidate> completions(const Command& root, std::vector<std::string> words,
                                                 const AskNames& ask,
                                                 const std::function<std::vector<std::string>()>& containers);

/// Returns the completion script of "bash", "zsh" or "fish".
[[nodiscard]] const char* completion_script(const std::string& shell);

/// Returns the names of an option separately: "-t", "--times".
[[nodiscard]] std::vector<std::string> names_of(const Option& option);

}  // namespace nacelle::cli
