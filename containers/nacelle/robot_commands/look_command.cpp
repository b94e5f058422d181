// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <poll.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ask/composition.hpp"
#include "ask/parameters.hpp"
#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/base/json_text.hpp"
#include "process/stop_signal.hpp"
#include "robot_commands/commands.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

constexpr const char* kPlugin = "nacelle::look::LookComponent";

struct LookWish {
  Whom whom;
  std::string address = "127.0.0.1", name = "look";
  std::int64_t port = 8080;
  bool detached = false, as_json = false;
};

/// The server: of a launch file, of an earlier `nacelle look`, or a new one.
struct LookServerFound {
  json component;
  bool is_new = false;
};

Result<LookServerFound, Problem> find_or_load(ask::Nodes& nodes, const LookWish& wish) {
  const auto list = ask::list_components(nodes, wish.whom.container);
  if (!list) return err(list.error());
  for (const auto& component : list.value()["components"]) {
    if (text_of(component, "plugin") == kPlugin) return LookServerFound{component, false};
  }
  const ask::LoadWish component{
      kPlugin, wish.name, "", {"address:=" + json(wish.address).dump(), fmt::format("port:={}", wish.port)},
      {},      {},        {}};
  auto loaded = ask::load_component(nodes, wish.whom.container, component);
  if (!loaded) return err(loaded.error());
  return LookServerFound{std::move(loaded).value(), true};
}

Result<json, Problem> links_of(ask::Nodes& nodes, const std::string& node) {
  const auto parameters = ask::list_parameters(nodes, node);
  if (!parameters) return err(parameters.error());
  std::string path;
  for (const auto& parameter : parameters.value()) {
    if (text_of(parameter, "name") == "link_file") path = parameter["value"].get<std::string>();
  }
  const auto text = read_regular_file(path);
  if (!text) {
    Problem problem = text.error();
    problem.way_out = "only the user who runs the robot may read its links; `nacelle lifecycle get " + node +
                      "` says whether it is active";
    return err(std::move(problem));
  }
  auto links = parse_json(*text);
  if (!links || !links->is_object())
    return err(Problem{Place{path, 0}, "is not a file of links", "start `nacelle look` anew"});
  return std::move(*links);
}

void print_links(const json& links) {
  print_text("To look and to operate:  %s\n", text_of(links, "operate").c_str());
  print_text("To look only:            %s\n", text_of(links, "view").c_str());
  print_text("In Foxglove:             %s\n", text_of(links, "foxglove").c_str());
}

/// Returns false if the container has ended.
bool wait_for_end(const control::Client& client) {
  const process::StopSignal stop;
  std::array<pollfd, 2> waits{pollfd{stop.descriptor(), POLLIN, 0}, pollfd{client.descriptor(), POLLIN, 0}};
  while (::poll(waits.data(), waits.size(), -1) < 0) {}
  return waits[0].revents != 0;
}

int run_look(const LookWish& wish) {
  auto client = connect(wish.whom);
  if (!client) return client.error();
  constexpr Duration kLimit = 8s;
  ask::Nodes nodes{client.value(), kLimit, 2s};
  const auto found = find_or_load(nodes, wish);
  if (!found) return complain(found.error());
  const std::string node = text_of(found->component, "node");
  const auto links = links_of(nodes, node);
  if (!links) return complain(links.error());
  if (wish.as_json) {
    print_text("%s\n", links->dump().c_str());
  } else {
    print_links(*links);
  }
  if (!found->is_new || wish.detached || wish.as_json) return kDone;
  print_text("Ctrl-C ends it\n");
  if (!flush_output()) return kDone;
  if (!wait_for_end(client.value())) {
    complain({"the container", "has ended", "start it again"});
    return kNoContainer;
  }
  auto again = connect(wish.whom);
  if (!again) return again.error();
  ask::Nodes ending{again.value(), kLimit, 2s};
  const auto unloaded = ask::unload_component(ending, wish.whom.container, node);
  return unloaded ? kDone : complain(unloaded.error());
}

}  // namespace

void add_look_command(Command& root) {
  auto wish = std::make_shared<LookWish>();
  Command& command = root.add("look", "show the robot in a browser, or in Foxglove, until Ctrl-C");
  command.option("--port", wish->port, "where it listens; 0: on a port that is free").within(0, 65535).with_default();
  command.option("--address", wish->address, "on which interface; 0.0.0.0: on every one, for other machines")
      .value("ADDRESS")
      .with_default();
  command.flag("--detach", wish->detached, "return, and leave it running: `nacelle component unload look` ends it");
  command.option("--node-name", wish->name, "the name of its node").value("NAME").with_default();
  command.option("--container", wish->whom.container, "of several containers, this one").value("NAME");
  command.flag("--json", wish->as_json, "print the links as JSON, and return");
  command.note(
      "If it runs already, its links are printed. The link is the key: the first one lets people change the "
      "robot, "
      "the second one lets them look and set the emergency stop. A launch file starts it as "
      "nacelle::look::LookComponent.");
  command.runs([wish] { return run_look(*wish); });
}

}  // namespace nacelle::cli
