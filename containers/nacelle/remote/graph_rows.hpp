// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "transport_dds/wire/remote_graph.hpp"

namespace nacelle::remote {

/// Returns "/arm/driver" for a namespace and a name.
[[nodiscard]] std::string full_name(const std::string& node_namespace, const std::string& name);

/// Returns the answer of the verb "graph" for remote nodes, in the form of answers/graph_verbs.hpp. The "id" of a node
/// is 0 and its "state" is empty. A node also has "host" and "pid" if it announces them, and "parameters" (it offers
/// the services of parameters). An endpoint also has a "gid".
[[nodiscard]] nlohmann::json graph_rows(const transport_dds::RemoteGraph& graph);

/// Returns the rows of a Stats frame: "name", "type", "writers", "readers" for each topic and type.
[[nodiscard]] nlohmann::json topic_rows(const transport_dds::RemoteGraph& graph);

}  // namespace nacelle::remote
