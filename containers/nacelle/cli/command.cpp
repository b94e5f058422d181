// SPDX-License-Identifier: Apache-2.0
#include "cli/command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <exception>
#include <type_traits>

#include "cli/completion.hpp"
#include "cli/program.hpp"
#include "nacelle/base/problem.hpp"

namespace nacelle::cli {
namespace {

std::string words_of_number(double value) {
  const bool whole = std::floor(value) == value && std::abs(value) <= 1e15;
  return whole ? fmt::format("{}", static_cast<std::int64_t>(value)) : fmt::format("{:g}", value);
}

bool takes_whole_number(const Option& option) {
  return std::holds_alternative<std::size_t*>(option.target) || std::holds_alternative<std::uint32_t*>(option.target);
}

bool takes_text(const Option& option) {
  return std::holds_alternative<std::string*>(option.target) ||
         std::holds_alternative<std::vector<std::string>*>(option.target);
}

/// What --help calls the value: "SECONDS (0.1 to 3600)", "bash|zsh|fish".
std::string value_words(const Option& option) {
  std::string words = !option.value_name.empty()        ? option.value_name
                      : !option.allowed.empty()         ? join(option.allowed, "|")
                      : option.completes == Names::File ? "FILE"
                      : takes_text(option)              ? "TEXT"
                                                        : "NUMBER";
  if (option.range) words += " (" + option.range_text() + ")";
  return words;
}

/// What is wrong with a text for this option, or nothing. CLI11's own words name C++ types, and its unsigned numbers wrap.
std::string wrong_with(const Option& option, const std::string& text) {
  const char* const end = text.data() + text.size();
  if (option.range) {
    double value = 0;
    const auto read = std::from_chars(text.data(), end, value);
    const bool fits =
        read.ec == std::errc{} && read.ptr == end && value >= option.range->first && value <= option.range->second;
    if (!fits) return "'" + text + "' is not a number from " + option.range_text();
  }
  if (takes_whole_number(option)) {
    std::uint64_t value = 0;
    const auto read = std::from_chars(text.data(), end, value);
    if (read.ec != std::errc{} || read.ptr != end) return "'" + text + "' is not a whole number of at least 0";
  }
  if (!option.allowed.empty() && std::ranges::find(option.allowed, text) == option.allowed.end())
    return "invalid value '" + text + "'; " + suggestion(text, option.allowed);
  return option.check ? option.check(text) : std::string{};
}

CLI::Option* add(CLI::App& app, const Option& option) {
  return std::visit(
      [&](const auto& target) -> CLI::Option* {
        using Target = std::decay_t<decltype(target)>;
        if constexpr (std::is_same_v<Target, bool*>) {
          return app.add_flag(option.names, *target, option.what);
        } else if constexpr (std::is_same_v<Target, std::function<void()>>) {
          return app.add_flag_callback(option.names, target, option.what);
        } else {
          CLI::Option* const made = app.add_option(option.names, *target, option.what);
          if constexpr (std::is_same_v<Target, std::vector<std::string>*>) {
            // One value per occurrence: the next word may be positional.
            if (!option.is_positional())
              made->expected(1)->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
          }
          made->type_name(value_words(option));
          made->check(CLI::Validator{[&option](const std::string& text) { return wrong_with(option, text); }, ""});
          return made;
        }
      },
      option.target);
}

void add_options(CLI::App& app, const Command& command) {
  for (const Option& option : command.options()) {
    CLI::Option* const made = add(app, option);
    if (option.is_required) made->required();
    if (option.is_hidden) made->group("");
    if (option.shows_default) made->capture_default_str();
    for (const auto& other : option.excluded) made->excludes(app.get_option(other));
  }
}

void add_command(CLI::App& app, const Command& command, const Command*& chosen) {
  add_options(app, command);
  app.footer(command.note());
  if (command.is_hidden()) app.group("");
  // CLI11 calls the callbacks of subcommands first.
  if (command.body()) {
    app.callback([&command, &chosen] {
      if (chosen == nullptr) chosen = &command;
    });
  }
  if (!command.subcommands().empty() && !command.body()) app.require_subcommand(1);
  for (const Command& below : command.subcommands())
    add_command(*app.add_subcommand(below.name(), below.what()), below, chosen);
}

// --- errors of the user ----------------------------------------------------------------------------------------------

/// How far the words lead, and the word that leads nowhere from there.
struct Way {
  const Command* command;
  std::string words, lost;
  std::string early;  ///< an option that stands where only commands can
  bool asks = false;  ///< --help or --version on the way
};

Way follow(const Command& root, int argc, char** argv) {
  Way way{&root, root.name(), "", "", false};
  for (int i = 1; i < argc && !way.command->subcommands().empty(); ++i) {
    const std::string word = argv[i];
    if (word.starts_with('-')) {
      const bool asks = word == "-h" || word == "--help" || word == "--version";
      if (!asks && way.early.empty() && !way.command->body()) way.early = word;
      way.asks = way.asks || asks;
      continue;
    }
    const auto& below = way.command->subcommands();
    const auto found = std::ranges::find_if(below, [&](const Command& one) { return one.name() == word; });
    if (found == below.end()) {
      if (!way.command->body()) way.lost = word;
      break;
    }
    way.command = &*found;
    way.words += " " + word;
  }
  return way;
}

/// "topic echo" of "nacelle topic echo": complain() says the program's name.
std::string where_of(const Way& way) {
  const auto space = way.words.find(' ');
  return space == std::string::npos ? "" : way.words.substr(space + 1);
}

std::vector<std::string> names_below(const Command& command) {
  std::vector<std::string> names;
  for (const Command& below : command.subcommands()) {
    if (!below.is_hidden()) names.push_back(below.name());
  }
  return names;
}

/// Returns "nacelle topic echo" for "echo".
std::vector<std::string> elsewhere(const Command& root, const std::string& word) {
  std::vector<std::string> found;
  for (const Command& group : root.subcommands()) {
    for (const Command& one : group.subcommands()) {
      if (one.name() == word) found.push_back("`" + root.name() + " " + group.name() + " " + word + "`");
    }
  }
  return found;
}

int complain_of_command(const Command& root, const Way& way) {
  if (!way.early.empty()) {
    return complain_of_usage({"option " + way.early, "must follow the command",
                              "write it after the whole command: " + root.name() + " topic list --json"});
  }
  const std::vector<std::string> names = names_below(*way.command);
  const std::string help = "see `" + way.words + " --help`";
  if (way.lost.empty())
    return complain_of_usage(
        {where_of(way), "a command is missing", way.command == &root ? help : suggestion("", names)});
  std::string way_out = nearest_name(way.lost, names);
  if (!way_out.empty()) {
    way_out = "did you mean `" + way.words + " " + way_out + "`?";
  } else if (const auto others = elsewhere(root, way.lost); !others.empty()) {
    way_out = "did you mean " + join(others, " or ") + "?";
  } else {
    way_out = way.command == &root ? help : suggestion(way.lost, names);
  }
  return complain_of_usage({where_of(way), "unknown command '" + way.lost + "'", way_out});
}

/// Words that no option or positional word of the command takes.
int complain_of_extras(const Way& way, const std::vector<std::string>& extras) {
  std::vector<std::string> names{"--help"};
  for (const Option& option : way.command->options()) {
    if (option.is_positional() || option.is_hidden) continue;
    for (const auto& name : names_of(option)) names.push_back(name);
  }
  const std::string help = "see `" + way.words + " --help`";
  for (const auto& word : extras) {
    if (!word.starts_with("-")) continue;
    const std::string near = nearest_name(word.substr(0, word.find('=')), names);
    return complain_of_usage(
        {where_of(way), "unknown option '" + word + "'", near.empty() ? help : "did you mean '" + near + "'?"});
  }
  return complain_of_usage({where_of(way), "unexpected argument '" + join(extras, " ") + "'", help});
}

bool asks_for_json(const CLI::App& app) {
  const CLI::Option* const option = app.get_option_no_throw("--json");
  return (option != nullptr && option->count() != 0) ||
         std::ranges::any_of(app.get_subcommands(), [](const CLI::App* below) { return asks_for_json(*below); });
}

}  // namespace

std::string Option::range_text() const {
  return words_of_number(range->first) + " to " + words_of_number(range->second);
}

int run_command_line(const Command& root, const std::string& version, int argc, char** argv) {
  const Way way = follow(root, argc, argv);
  const bool leads =
      way.lost.empty() && way.early.empty() && (way.command->subcommands().empty() || way.command->body());
  if (!way.asks && !leads) return complain_of_command(root, way);
  CLI::App app{root.what(), root.name()};
  app.set_version_flag("--version", version);
  const Command* chosen = nullptr;
  try {
    add_command(app, root, chosen);
    app.parse(argc, argv);
    if (asks_for_json(app)) complain_in_json();
    return chosen == nullptr ? kUsage : chosen->body()();
  } catch (const CLI::ExtrasError&) {
    return complain_of_extras(way, app.remaining(true));
  } catch (const CLI::ParseError& e) {
    // --help and --version come this way too; CLI11's own numbers above 100 mean wrong usage.
    if (e.get_exit_code() == 0) return app.exit(e);
    // What is missing may stand there, misspelt.
    const auto extras = app.remaining(true);
    if (std::ranges::any_of(extras, [](const std::string& word) { return word.starts_with('-'); }))
      return complain_of_extras(way, extras);
    const std::string what = e.what();
    return complain_of_usage({where_of(way), what, what.ends_with('?') ? "" : "see `" + way.words + " --help`"});
  } catch (const std::exception& e) {
    std::fprintf(stderr, "nacelle: %s\n", e.what());
    return kFailed;
  }
}

}  // namespace nacelle::cli
