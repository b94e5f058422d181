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
  std::set<std::string> standard;  ///< Names, shown or not.
  std::size_t left_out = 0;        ///< Of the standard ones.
};

/// Of a graph (answers/graph_verbs.hpp); `hidden`, `standard`: with those too.
[[nodiscard]] NodeView view_of(const nlohmann::json& graph, const std::string& node, bool hidden, bool standard);
/// Each section as a list: "service_servers".
void add_to_json(nlohmann::json& answer, const NodeView& view);
/// As `ros2 node info` prints them.
void print(const NodeView& view);

}  // namespace nacelle::cli
