// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "ask/nodes.hpp"

namespace nacelle::ask {

/// Returns what every EKF, or the one of that name, measures of itself:
///
///   "filters": [{"node", "initialised", "inputs": [{"name", "rate_hz", "delay_s", "received", "fused", "late", "waiting", "lost",
///                "rejected": {cause: count}, "axes": [{"name", "nis", "noise", "offset", "scale"}], "sentence"}]}]
///
/// "rejected" has the causes that occurred. "axes" is empty before an input has enough measurements. "sentence": what a builder
/// should look at first; empty if there is nothing.
/// Errors: no such node; no filter at all; as Nodes::call().
[[nodiscard]] Result<nlohmann::json, Problem> list_filters(Nodes& nodes, const std::string& filter);

/// Returns one element of "filters" from a filter's answer to its service ~/status. Pure.
[[nodiscard]] nlohmann::json filter_of(const std::string& node, const nlohmann::json& response);

}  // namespace nacelle::ask
