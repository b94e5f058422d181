// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>

#include "ask/network.hpp"
#include "asking.hpp"
#include "commands.hpp"
#include "output.hpp"
#include "program.hpp"

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
    Command& command = exported ? group.add("on", "other machines may see it, as far as the launch file's list goes")
                                : group.add("off", "what the launch file says, but for this machine at most");
    add_common_options(command, wish->whom.container, wish->as_json);
    command.note(
        "ROS 2's tools meet all nodes anew; within the robot nothing changes. It holds until the container ends.\n"
        "What may leave and who may see it: docs/network.md in the source tree.");
    command.runs([wish, exported] {
      return ask_nodes(
          wish->whom, wish->as_json,
          [&](ask::Nodes& nodes) { return ask::set_network(nodes, wish->whom.container, exported); },
          [](const json& state) { print_text("%s\n", text_of(state, "line").c_str()); });
    });
  }
}

}  // namespace nacelle::cli
