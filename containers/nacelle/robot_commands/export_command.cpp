// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>

#include "ask/network.hpp"
#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "robot_commands/commands.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct ExportWish {
  Whom whom;
  bool as_json = false;
};

}  // namespace

void add_export_command(Command& root) {
  Command& group = root.add("export", "show a running robot to other machines, or keep it on this one");
  auto wish = std::make_shared<ExportWish>();
  for (const bool exported : {true, false}) {
    Command& command = exported ? group.add("on", "show the robot to other machines, limited by the launch file's list")
                                : group.add("off", "return to the launch file's mode, but at most this machine");
    add_common_options(command, wish->whom.container, wish->as_json);
    command.note(
        "ROS 2's tools discover all nodes again; within the robot nothing changes. Lasts until the container ends.\n"
        "Details: docs/network.md in the source tree.");
    command.runs([wish, exported] {
      return ask_nodes(
          wish->whom, wish->as_json,
          [&](ask::Nodes& nodes) { return ask::set_network(nodes, wish->whom.container, exported); },
          [](const json& state) { print_text("%s\n", text_of(state, "line").c_str()); });
    });
  }
}

}  // namespace nacelle::cli
