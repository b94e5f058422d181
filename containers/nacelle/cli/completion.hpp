// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "command.hpp"

namespace nacelle::cli {

/// A word that may stand at the cursor.
struct Candidate {
  std::string word, what;  ///< what: a few words about it; may be empty.
  friend bool operator==(const Candidate&, const Candidate&) = default;
};

/// What a name is completed from, beside the tree of commands.
struct NameQuestion {
  Names names = Names::Nothing;
  std::string container;                ///< What --container says; empty: nothing.
  std::vector<std::string> positional;  ///< The positional words before this one.
};
/// Answers nothing where nothing is known; must not wait long.
using AskNames = std::function<std::vector<std::string>(const NameQuestion&)>;

/// What may stand at the last of the words, which begins as it does (it may be empty): the words of a command line behind the
/// program's name. For a file nothing is answered: the shell completes those. Pure but for `ask` and `containers`, which names
/// those that run.
[[nodiscard]] std::vector<Candidate> completions(const Command& root, std::vector<std::string> words,
                                                 const AskNames& ask,
                                                 const std::function<std::vector<std::string>()>& containers);

/// The function that a shell calls: "bash", "zsh" or "fish".
[[nodiscard]] const char* completion_script(const std::string& shell);

/// The names of an option one by one: "-t", "--times".
[[nodiscard]] std::vector<std::string> names_of(const Option& option);

}  // namespace nacelle::cli
