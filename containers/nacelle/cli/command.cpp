// SPDX-License-Identifier: Apache-2.0
#include "command.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <type_traits>

#include "program.hpp"

namespace nacelle::cli {
namespace {

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
            // One value an occurrence: what follows it may be a positional word.
            if (!option.is_positional())
              made->expected(1)->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
          }
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
    if (!option.value_name.empty()) made->type_name(option.value_name);
    if (option.range) made->check(CLI::Range(option.range->first, option.range->second));
    if (!option.allowed.empty()) made->check(CLI::IsMember(option.allowed));
    if (option.check)
      made->check(CLI::Validator{[by = option.check](const std::string& text) { return by(text); }, ""});
    if (option.shows_default) made->capture_default_str();
    for (const auto& other : option.excluded) made->excludes(app.get_option(other));
  }
}

void add_command(CLI::App& app, const Command& command, const Command*& chosen) {
  add_options(app, command);
  app.footer(command.note());
  if (command.is_hidden()) app.group("");
  if (command.body()) app.callback([&command, &chosen] { chosen = &command; });
  if (!command.subcommands().empty()) app.require_subcommand(1);
  for (const Command& below : command.subcommands())
    add_command(*app.add_subcommand(below.name(), below.what()), below, chosen);
}

}  // namespace

int run_command_line(const Command& root, const std::string& version, int argc, char** argv) {
  CLI::App app{root.what(), root.name()};
  app.set_version_flag("--version", version);
  const Command* chosen = nullptr;
  try {
    add_command(app, root, chosen);
    app.parse(argc, argv);
    return chosen == nullptr ? kUsage : chosen->body()();
  } catch (const CLI::ParseError& e) {
    // --help and --version come this way too; CLI11's own numbers above 100 mean wrong usage.
    return app.exit(e) == 0 ? kDone : kUsage;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "nacelle: %s\n", e.what());
    return kFailed;
  }
}

}  // namespace nacelle::cli
