// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "transport_dds/wire/remote_graph.hpp"

namespace nacelle::remote {

/// Returns "/arm/driver"; for an endpoint of an unknown node, ROS 2's placeholder.
[[nodiscard]] std::string full_name(const std::string& node_namespace, const std::string& name);

/// The answer of the verb "graph", as answers/graph_verbs.hpp has it, for remote nodes. They have no "id" (0) and no
/// known "state"; a node has "host" and "pid" if it announces them, and "parameters"; an endpoint has a "gid".
[[nodiscard]] nlohmann::json graph_rows(const transport_dds::RemoteGraph& graph);

/// What a Stats frame has of each topic and type: "name", "type", "writers", "readers".
[[nodiscard]] nlohmann::json topic_rows(const transport_dds::RemoteGraph& graph);

}  // namespace nacelle::remote
