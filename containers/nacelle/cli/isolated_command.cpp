// SPDX-License-Identifier: Apache-2.0
#include <sys/socket.h>
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "commands.hpp"
#include "nacelle/session/foreign_programs.hpp"
#include "nacelle/session/isolated_process.hpp"
#include "program.hpp"

namespace nacelle::cli {
namespace {

struct Wish {
  std::string name, carrier;
  long parent_pid = 0;
};

int run(const Wish& wish) {
  const session::StopSignal stop;
  die_with_parent(wish.parent_pid);
  struct stat about {};
  if (::fstat(session::kInheritedDescriptor, &about) != 0 || !S_ISSOCK(about.st_mode)) {
    complain({"isolated", "there is no container at the other end",
              "a container starts this for a component with `isolate: process`"});
    return kUsage;
  }
  const SystemClock clock;
  return session::run_isolated(session::kInheritedDescriptor, wish.name, wish.carrier, program_places(), clock, stop);
}

}  // namespace

void add_isolated_command(CLI::App& app, int& exit_code) {
  auto wish = std::make_shared<Wish>();
  CLI::App* const command = app.add_subcommand("isolated", "the process of a component with `isolate: process`");
  command->group("");
  command->add_option("--name", wish->name, "the component")->required();
  command->add_option("--carrier", wish->carrier, "for its streams");
  command->add_option("--parent", wish->parent_pid, "end when this process ends");
  command->callback([wish, &exit_code] { exit_code = run(*wish); });
}

}  // namespace nacelle::cli
