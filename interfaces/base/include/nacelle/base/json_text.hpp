// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle {

/// Reads JSON: the one way in which a JSON text becomes a value (test/policy/check_tree.py). `Json` is nlohmann's json or ordered_json;
/// the parser is compiled once, in the library. `watch` sees every step of the parser. Errors: deeper than kMostNesting; no JSON, with
/// the parser's own words. `where` is empty or a line. Throws std::bad_alloc only.
template <typename Json = nlohmann::json>
[[nodiscard]] Result<Json, Problem> parse_json(std::string_view text,
                                               const typename Json::parser_callback_t& watch = nullptr);

/// The same where the reason is of no interest. Returns a discarded value (`is_discarded()`) on error.
template <typename Json = nlohmann::json>
[[nodiscard]] Json parse_json_or_discard(std::string_view text);

}  // namespace nacelle
