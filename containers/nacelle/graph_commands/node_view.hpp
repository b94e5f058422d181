// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>

namespace nacelle::cli {

/// A node's topics, services and actions, in ros2's sections: "Subscribers", "Service Servers".
struct NodeView {
  /// Names with their types.
  using Section = std::map<std::string, std::set<std::string>>;
  std::map<std::string, Section> sections;
  std::set<std::string> standard;  ///< Names that every node has, shown or not.
  std::size_t left_out = 0;        ///< Standard names that are not shown.
};

/// Returns the view of a node of a graph (answers/graph_verbs.hpp). `hidden` and `standard` include names of these
/// kinds.
[[nodiscard]] NodeView view_of(const nlohmann::json& graph, const std::string& node, bool hidden, bool standard);
/// Adds each section as a list, under a key such as "service_servers".
void add_to_json(nlohmann::json& answer, const NodeView& view);
/// Prints the view in the form of `ros2 node info`.
void print(const NodeView& view);

}  // namespace nacelle::cli
