// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "ask/nodes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::ask {

/// Returns the counters of a container since its start: the fields of nacelle_interfaces/srv/GetStatistics. A row of
/// "components" has "executor", "own_threads", "callbacks" and "samples" for a component in the container's process,
/// and "process" and "rss_bytes" for a component in its own process.
///
/// `container`: a name, or empty for the only one. Errors: as Nodes::ask_container().
[[nodiscard]] Result<nlohmann::json, Problem> statistics(Nodes& nodes, const std::string& container);

}  // namespace nacelle::ask
