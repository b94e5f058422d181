// SPDX-License-Identifier: Apache-2.0
#include <sys/socket.h>
#include <sys/stat.h>

#include <memory>

#include "cli/program.hpp"
#include "isolation/isolated_process.hpp"
#include "process/foreign_programs.hpp"
#include "robot_commands/commands.hpp"

namespace nacelle::cli {
namespace {

struct IsolatedWish {
  std::string name, carrier;
  long parent_pid = 0;
};

int run(const IsolatedWish& wish) {
  const process::StopSignal stop;
  die_with_parent(wish.parent_pid);
  struct stat about {};
  if (::fstat(process::kInheritedDescriptor, &about) != 0 || !S_ISSOCK(about.st_mode)) {
    complain({"isolated", "there is no container at the other end",
              "a container starts this for a component with `isolate: process`"});
    return kUsage;
  }
  const SystemClock clock;
  return isolation::run_isolated(process::kInheritedDescriptor, wish.name, wish.carrier, program_places(), clock, stop);
}

}  // namespace

void add_isolated_command(Command& root) {
  auto wish = std::make_shared<IsolatedWish>();
  Command& command = root.add("isolated", "the process of a component with `isolate: process`").hidden();
  command.option("--name", wish->name, "the component").required();
  command.option("--carrier", wish->carrier, "for its streams");
  command.option("--parent", wish->parent_pid, "end when this process ends");
  command.runs([wish] { return run(*wish); });
}

}  // namespace nacelle::cli
