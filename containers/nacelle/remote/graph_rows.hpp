// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "transport_dds/wire/remote_graph.hpp"

namespace nacelle::remote {

/// "/arm/driver"; of an endpoint whose node is not known, ROS 2's words for that.
[[nodiscard]] std::string full_name(const std::string& node_namespace, const std::string& name);

/// The answer of the verb "graph", as answers/graph_verbs.hpp has it, of the nodes outside. They have no "id" (0)
/// and no known "state"; a node says its "host" and "pid" where it announces them and whether it has "parameters", an
/// endpoint its "gid".
[[nodiscard]] nlohmann::json graph_rows(const transport_dds::RemoteGraph& graph);

/// What a Stats frame has of each topic and type: "name", "type", "writers", "readers".
[[nodiscard]] nlohmann::json topic_rows(const transport_dds::RemoteGraph& graph);

}  // namespace nacelle::remote
