// SPDX-License-Identifier: Apache-2.0
#include "nacelle/description/xacro.hpp"

#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cli/program.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/base/printable.hpp"
#include "nacelle/launch/load_plan.hpp"
#include "offline_commands/commands.hpp"

namespace nacelle::cli {
namespace {

struct XacroWish {
  std::string file, output;
  std::vector<std::string> arguments;
};

int run(const XacroWish& wish) {
  auto arguments = launch::parse_arguments(wish.arguments);
  if (!arguments) {
    for (const auto& problem : arguments.error()) complain(problem);
    return kUsage;
  }
  auto prefixes = program_places().prefixes;
  auto expanded = description::expand_xacro(wish.file, arguments.value(), description::machine(std::move(prefixes)));
  if (!expanded) return complain(expanded.error());
  for (const auto& warning : expanded.value().warnings)
    std::fprintf(stderr, "nacelle: %s\n", printable_entry(warning).c_str());
  const std::string& urdf = expanded.value().urdf;
  if (!wish.output.empty()) {
    const auto written = write_whole_file(wish.output, urdf);
    return written ? kDone : complain(written.error());
  }
  const bool whole = std::fwrite(urdf.data(), 1, urdf.size(), stdout) == urdf.size() && std::fflush(stdout) == 0;
  return whole ? kDone : complain({"standard output", "could not take it all", ""});
}

}  // namespace

void add_xacro_command(Command& root) {
  auto wish = std::make_shared<XacroWish>();
  Command& command = root.add("xacro", "print the URDF that a xacro file describes");
  command.option("file", wish->file, "a .xacro file").required().names_a(Names::File);
  command.option("arguments", wish->arguments, "name:=value for the file's arguments");
  command.option("-o,--output", wish->output, "write to this file instead of stdout").names_a(Names::File);
  command.runs([wish] { return run(*wish); });
}

}  // namespace nacelle::cli
