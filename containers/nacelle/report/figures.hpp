// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace nacelle::report {

// What `nacelle streams` and `nacelle top` show, made of two answers of ask::statistics() (ask/statistics.hpp): rates
// are those between the two, totals those of the second. Pure.

/// {"seconds": ..., "streams": [{"name", "type", "hz", "age_s", "dropped": {cause: count}, "dropped_per_s", "late", ...}]}
/// A reader is late while it loses messages, misses the deadline that it asks for, or lets its queue fill; "why" says what
/// keeps it from them.
[[nodiscard]] nlohmann::json streams_between(const nlohmann::json& before, const nlohmann::json& after);
/// {"seconds", "cpu_percent", "rss_mb", "threads", "components": [...], "other_threads": [...]}, components by CPU.
/// "cpu_by" says what a component's CPU was taken from: "threads" (its own, exact), "process" (its own, exact), or
/// "callbacks" (it shares a thread: about one callback in 128 is measured).
[[nodiscard]] nlohmann::json components_between(const nlohmann::json& before, const nlohmann::json& after);

/// As tables for people. Columns that do not fit into so many characters are left out, the least important first; 0: none is.
[[nodiscard]] std::string streams_text(const nlohmann::json& streams, std::size_t width = 0);
[[nodiscard]] std::string components_text(const nlohmann::json& components, std::size_t width = 0);

}  // namespace nacelle::report
