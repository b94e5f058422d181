// SPDX-License-Identifier: Apache-2.0
// Containers of the network.
#include <nacelle_interfaces/srv/change_state.hpp>
#include <set>
#include <string_view>
#include <utility>

#include "nacelle/base/name_fault.hpp"
#include "nacelle/base/names.hpp"
#include "remote/graph_rows.hpp"
#include "remote/remote_nodes.hpp"

namespace nacelle::remote {
namespace {

constexpr std::string_view kListNodes = "/_container/list_nodes", kChangeState = "/_container/change_state";

/// The nodes that are containers.
std::set<std::string> containers_of(const RemoteNetwork& network) {
  std::set<std::string> names;
  const auto all = network.look([](const auto& graph) { return graph.services(); });
  for (const auto& [name, types] : all) {
    if (name.ends_with(kListNodes) && types.contains("composition_interfaces/srv/ListNodes"))
      names.insert(name.substr(0, name.size() - kListNodes.size()));
  }
  return names;
}

std::optional<transport_dds::RemoteNode> node_of(const RemoteNetwork& network, const std::string& name) {
  for (auto& node : network.look([](const auto& graph) { return graph.nodes(); })) {
    if (full_name(node.node_namespace, node.name) == name) return std::move(node);
  }
  return std::nullopt;
}

}  // namespace

Result<std::string, Problem> container_named(RemoteNetwork& network, const std::string& name) {
  const std::string wanted = name.empty() || name.starts_with('/') ? name : "/" + name;
  // One that is named is enough; to know that there is only one takes the whole time.
  if (wanted.empty()) {
    network.find_all();
  } else {
    static_cast<void>(network.find([&] { return containers_of(network).contains(wanted); }));
  }
  const auto all = containers_of(network);
  if (all.contains(wanted)) return wanted;
  if (name.empty() && all.size() == 1) return *all.begin();
  const std::vector<std::string> names(all.begin(), all.end());
  if (names.empty())
    return err(Problem{"containers", "none was found in " + network.where(), "see `nacelle node list --remote`",
                       NameFault::Unknown});
  if (name.empty())
    return err(Problem{"containers", "there are " + join(names), "give --container one of them", NameFault::Ambiguous});
  return err(Problem{"container '" + name + "'", "is not there in " + network.where(), suggestion(wanted, names),
                     NameFault::Unknown, name});
}

std::string container_of(const RemoteNetwork& network, const std::string& node) {
  using nacelle_interfaces::srv::ChangeState;
  const auto found = node_of(network, node);
  if (!found) return {};
  const auto services = network.look([&](const auto& graph) {
    return graph.services_of(found->participant, "nacelle_interfaces/srv/ChangeState",
                             ChangeState::Request::message_type().hash);
  });
  for (const auto& name : services) {
    if (name.ends_with(kChangeState)) return name.substr(0, name.size() - kChangeState.size());
  }
  return {};
}

}  // namespace nacelle::remote
