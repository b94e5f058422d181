// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace nacelle::report {

// The content of `nacelle streams` and `nacelle top`, computed from two answers of ask::statistics()
// (ask/statistics.hpp). Rates are those between the two, totals those of the second. Pure.

/// Returns {"seconds": ..., "streams": [{"name", "type", "hz", "age_s", "dropped": {cause: count}, "dropped_per_s",
/// "late", ...}]}. A reader is late if it loses messages, misses its deadline, or has a queue that is at least half
/// full. "why" is the cause.
[[nodiscard]] nlohmann::json streams_between(const nlohmann::json& before, const nlohmann::json& after);
/// Returns {"container", "seconds", "cpu_percent", "rss_mb", "threads", "components": [...], "other_threads": [...]},
/// with the components sorted by CPU load. "cpu_by" is the source of a component's CPU load: "threads" (its own,
/// exact), "process" (its own, exact), or "callbacks" (it shares a thread: about one callback in 128 is measured).
[[nodiscard]] nlohmann::json components_between(const nlohmann::json& before, const nlohmann::json& after);

/// Returns the figures as a table for users. If the columns do not fit into `width` characters, the least important
/// ones are left out; 0: no limit.
[[nodiscard]] std::string streams_text(const nlohmann::json& streams, std::size_t width = 0);
[[nodiscard]] std::string components_text(const nlohmann::json& components, std::size_t width = 0);

}  // namespace nacelle::report
