// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle {

// ROS 2's words for policies and values, and durations as people write them.
// Errors of the parsers: a Problem without `where`, naming the word and the nearest valid one.

[[nodiscard]] std::string to_text(Reliability value);
[[nodiscard]] std::string to_text(Durability value);
[[nodiscard]] std::string to_text(History value);
[[nodiscard]] std::string to_text(Liveliness value);
[[nodiscard]] std::string to_text(PoolPolicy value);
/// "100ms", "1.5s", "250us", "7ns"; the shortest that parse_duration() reads back as the same.
[[nodiscard]] std::string to_text(Duration value);
/// The same for a deadline, lifespan or lease: "infinite" when not given, "best_available".
[[nodiscard]] std::string policy_duration_text(Duration value);
/// "keep_last 10, reliable, volatile" and what else is given.
[[nodiscard]] std::string to_text(const QoS& qos);

[[nodiscard]] Result<Reliability, Problem> parse_reliability(std::string_view text);
[[nodiscard]] Result<Durability, Problem> parse_durability(std::string_view text);
[[nodiscard]] Result<History, Problem> parse_history(std::string_view text);
[[nodiscard]] Result<Liveliness, Problem> parse_liveliness(std::string_view text);
[[nodiscard]] Result<PoolPolicy, Problem> parse_pool_policy(std::string_view text);
/// A number and its unit (ns, us, ms, s, min, h), or "infinite" (Duration::max()). Never negative.
[[nodiscard]] Result<Duration, Problem> parse_duration(std::string_view text);

}  // namespace nacelle
