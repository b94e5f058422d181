// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace nacelle::cli {

/// The kind of thing that a word of the command line names. The shell completes it from the running container or from
/// the installed files.
enum class Names {
  Nothing,
  Topic,
  Node,
  Service,
  Action,
  Type,
  ServiceType,
  ActionType,
  Plugin,
  Parameter,
  Frame,
  File
};

/// An option, a flag or a positional word of a command. Command creates it. Its setters return it, so that calls can be
/// chained.
struct Option {
  using Target = std::variant<bool*, std::string*, double*, std::size_t*, std::uint32_t*, long*,
                              std::vector<std::string>*, std::function<void()>>;

  /// "-t,--times", or "topic" for a positional word.
  std::string names, what;
  /// Written before the command runs. The code that adds the option owns the target. For a flag, a function is called.
  Target target;
  bool is_required = false, is_hidden = false, shows_default = false;
  /// The name of the value in --help: SECONDS, FILE.
  std::string value_name;
  Names completes = Names::Nothing;
  /// If this flag is given, the word names this kind instead.
  std::pair<std::string, Names> completes_with{"", Names::Nothing};
  std::optional<std::pair<double, double>> range;
  std::vector<std::string> allowed;
  /// Returns the error of a value, or an empty text.
  std::function<std::string(const std::string&)> check;
  /// Names of the options that cannot be combined with this one.
  std::vector<std::string> excluded;

  Option& required() { return is_required = true, *this; }
  Option& hidden() { return is_hidden = true, *this; }
  /// Shows the target's initial value in --help.
  Option& with_default() { return shows_default = true, *this; }
  Option& value(std::string name) { return value_name = std::move(name), *this; }
  Option& names_a(Names what_it_names) { return completes = what_it_names, *this; }
  Option& names_a_with(std::string flag, Names what_it_names) {
    return completes_with = {std::move(flag), what_it_names}, *this;
  }
  Option& within(double least, double most) { return range = {least, most}, *this; }
  Option& one_of(std::vector<std::string> values) { return allowed = std::move(values), *this; }
  Option& checked(std::function<std::string(const std::string&)> by) { return check = std::move(by), *this; }
  Option& not_with(std::string other) { return excluded.push_back(std::move(other)), *this; }

  /// Returns "0.1 to 3600". Only for an option with a range.
  [[nodiscard]] std::string range_text() const;
  [[nodiscard]] bool is_positional() const { return names.empty() || names.front() != '-'; }
  [[nodiscard]] bool is_flag() const { return target.index() == 0 || target.index() == 7; }
};

/// A command of the program as data. The parser, --help, the completion, the manual page and docs/cli.md are generated
/// from it.
///
/// A command has subcommands, a function, or both. A command without a function requires one of its subcommands.
/// Options are read in the order in which they were added. References stay valid while the root exists.
class Command {
 public:
  explicit Command(std::string name, std::string what) : name_(std::move(name)), what_(std::move(what)) {}

  Command& add(std::string name, std::string what) {
    return subcommands_.emplace_back(std::move(name), std::move(what));
  }
  /// Adds an option with a value or, for a name without dashes, a positional word. A vector collects every occurrence
  /// of an option; as a positional it takes all remaining words.
  template <typename T>
  Option& option(const std::string& names, T& target, const std::string& what) {
    return take(names, &target, what);
  }
  Option& flag(std::string names, bool& target, std::string what) {
    return take(std::move(names), &target, std::move(what));
  }
  Option& flag(std::string names, std::function<void()> then, std::string what) {
    return take(std::move(names), std::move(then), std::move(what));
  }
  /// Sets the command's function; its result is the process's exit code (program.hpp). The function prints errors to
  /// stderr.
  Command& runs(std::function<int()> body) { return run_ = std::move(body), *this; }
  /// Omits the command from --help, completion and the manual page.
  Command& hidden() { return is_hidden_ = true, *this; }
  /// Adds text below the options in --help and the manual page.
  Command& note(std::string text) { return note_ = std::move(text), *this; }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& what() const { return what_; }
  [[nodiscard]] const std::string& note() const { return note_; }
  [[nodiscard]] bool is_hidden() const { return is_hidden_; }
  [[nodiscard]] const std::deque<Command>& subcommands() const { return subcommands_; }
  [[nodiscard]] const std::deque<Option>& options() const { return options_; }
  [[nodiscard]] const std::function<int()>& body() const { return run_; }

 private:
  Option& take(std::string names, Option::Target target, std::string what) {
    Option& option = options_.emplace_back();
    option.names = std::move(names);
    option.target = std::move(target);
    option.what = std::move(what);
    return option;
  }

  std::string name_, what_, note_;
  bool is_hidden_ = false;
  std::deque<Command> subcommands_;
  std::deque<Option> options_;
  std::function<int()> run_;
};

/// Reads the command line and runs the command that it names. Returns the command's exit code; 0 after --help and
/// --version, 2 for wrong usage, which is reported on stderr.
int run_command_line(const Command& root, const std::string& version, int argc, char** argv);

}  // namespace nacelle::cli
