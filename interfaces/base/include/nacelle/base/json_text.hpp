// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "nacelle/base/nesting.hpp"

namespace nacelle {

/// Reads JSON: the one way in which a JSON text becomes a value (test/policy/check_tree.py). `Json` may be ordered_json.
/// `watch` sees every step of the parser. Errors: deeper than kMostNesting; no JSON, with the parser's own words. `where` is empty or a
/// line. Throws std::bad_alloc only.
template <typename Json = nlohmann::json>
[[nodiscard]] Result<Json, Problem> parse_json(std::string_view text,
                                               const typename Json::parser_callback_t& watch = nullptr) {
  if (auto bounded = check_json_nesting(text); !bounded) return err(bounded.error());
  try {
    return Json::parse(text, watch);
  } catch (const nlohmann::json::exception& fault) {
    const std::string words = fault.what();  // "[json.exception.parse_error.101] parse error at line 1, ..."
    const auto end = words.starts_with('[') ? words.find("] ") : std::string::npos;
    return err(Problem{"", "this is not JSON: " + (end == std::string::npos ? words : words.substr(end + 2)), ""});
  }
}

/// The same where the reason is of no interest. Returns a discarded value (`is_discarded()`) on error.
template <typename Json = nlohmann::json>
[[nodiscard]] Json parse_json_or_discard(std::string_view text) {
  if (!check_json_nesting(text)) return Json(nlohmann::json::value_t::discarded);
  return Json::parse(text, nullptr, false);
}

}  // namespace nacelle
