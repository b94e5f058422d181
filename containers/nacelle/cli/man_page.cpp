// SPDX-License-Identifier: Apache-2.0
#include "cli/man_page.hpp"

#include <fmt/format.h>

#include "cli/completion.hpp"

namespace nacelle::cli {
namespace {

bool takes_many(const Option& option) { return std::holds_alternative<std::vector<std::string>*>(option.target); }

std::string value_of(const Option& option) {
  if (!option.value_name.empty()) return option.value_name;
  return option.is_positional() ? option.names : "VALUE";
}

/// "topic echo [OPTIONS] topic [type]"
void append_synopsis(std::string& out, const std::string& path, const Command& command) {
  out += ".B " + roff(path) + "\n";
  bool has_options = false;
  for (const Option& option : command.options())
    has_options = has_options || (!option.is_positional() && !option.is_hidden);
  if (has_options) out += "[\\fIoptions\\fR]\n";
  for (const Option& option : command.options()) {
    if (!option.is_positional() || option.is_hidden) continue;
    const std::string name = "\\fI" + roff(option.names) + "\\fR" + (takes_many(option) ? " ..." : "");
    out += option.is_required ? name + "\n" : "[" + name + "]\n";
  }
}

std::string described(const Option& option) {
  std::string text = option.what;
  const auto say = [&](const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
  if (!option.allowed.empty()) {
    std::string all;
    for (const auto& value : option.allowed) all += (all.empty() ? "" : ", ") + value;
    say("one of " + all);
  }
  if (option.range) say(option.range_text());
  return text.empty() ? option.names : text;
}

void append_options(std::string& out, const Command& command) {
  for (const Option& option : command.options()) {
    if (option.is_hidden) continue;
    std::string heading;
    for (const auto& name : names_of(option)) {
      const char* const font = option.is_positional() ? "\\fI" : "\\fB";
      heading += (heading.empty() ? "" : ", ") + (font + roff(name)) + "\\fR";
    }
    if (!option.is_positional() && !option.is_flag()) heading += " \\fI" + roff(value_of(option)) + "\\fR";
    out += ".TP\n" + heading + "\n" + roff(described(option)) + "\n";
  }
}

/// Its lines are broken by hand.
void append_note(std::string& out, const std::string& note) {
  if (note.empty()) return;
  out += ".PP\n.nf\n" + roff(note) + "\n.fi\n";
}

void append_command(std::string& out, const std::string& path, const Command& command) {
  if (command.is_hidden()) return;
  if (command.body()) {
    out += ".SS " + roff(path) + "\n" + roff(command.what()) + ".\n.PP\n";
    append_synopsis(out, path, command);
    append_options(out, command);
    append_note(out, command.note());
  }
  for (const Command& below : command.subcommands()) append_command(out, path + " " + below.name(), below);
}

}  // namespace

std::string roff(const std::string& text) {
  std::string out;
  bool at_begin = true;
  for (const char c : text) {
    if (at_begin && (c == '.' || c == '\'')) out += "\\&";
    switch (c) {
      case '\\': out += "\\e"; break;
      case '-': out += "\\-"; break;
      case '`': out += "\\(ga"; break;
      case '\'': out += "\\(aq"; break;
      case '^': out += "\\(ha"; break;
      case '~': out += "\\(ti"; break;
      default: out += c;
    }
    at_begin = c == '\n';
  }
  return out;
}

std::string man_page(const Command& root, const std::string& version) {
  const std::string& name = root.name();
  std::string out = fmt::format(".TH {} 1 \"\" \"{} {}\" \"User Commands\"\n", "NACELLE", name, version);
  const std::size_t colon = root.what().find(": ");
  out += ".SH NAME\n" + name + " \\- " +
         roff(colon == std::string::npos ? root.what() : root.what().substr(colon + 2)) + "\n";
  out += ".SH SYNOPSIS\n.B " + name + "\n\\fIcommand\\fR [\\fIoptions\\fR] ...\n";
  out +=
      ".SH DESCRIPTION\nCommands ask the running container over its local socket, or work without one. Every command "
      "has\n"
      ".BR \\-\\-help .\n";
  append_note(out, root.note());
  out += ".SH COMMANDS\n";
  for (const Command& command : root.subcommands()) append_command(out, name + " " + command.name(), command);
  out +=
      ".SH EXIT STATUS\n"
      ".TP\n0\nsuccess\n.TP\n1\nfailure; stderr has the reason and the fix\n.TP\n2\nwrong usage\n.TP\n3\nno container "
      "is "
      "running\n";
  out +=
      ".SH ENVIRONMENT\n"
      ".TP\n.B NACELLE_CONTAINER\nThe container to ask, unless \\fB\\-\\-container\\fR names one.\n"
      ".TP\n.B NACELLE_COMPONENT_PATH\nFurther folders with components, separated by colons.\n"
      ".TP\n.B NACELLE_PREFIX_PATH\nFurther prefixes of installed packages, separated by colons.\n"
      ".TP\n.B NACELLE_INTERFACE_PATH\nFurther folders with libraries of message types, separated by colons.\n"
      ".TP\n.B XDG_RUNTIME_DIR\nWhere containers have their sockets and states, in the folder nacelle: in RAM. If it "
      "is not set, /run/nacelle or /dev/shm.\n";
  return out;
}

}  // namespace nacelle::cli
