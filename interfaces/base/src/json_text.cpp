// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/json_text.hpp"

#include <string>

#include "nacelle/base/nesting.hpp"

namespace nacelle {

template <typename Json>
Result<Json, Problem> parse_json(std::string_view text, const typename Json::parser_callback_t& watch) {
  if (auto bounded = check_json_nesting(text); !bounded) return err(bounded.error());
  try {
    return Json::parse(text, watch);
  } catch (const nlohmann::json::exception& fault) {
    const std::string words = fault.what();  // "[json.exception.parse_error.101] parse error at line 1, ..."
    const auto end = words.starts_with('[') ? words.find("] ") : std::string::npos;
    return err(Problem{"", "this is not JSON: " + (end == std::string::npos ? words : words.substr(end + 2)), ""});
  }
}

template <typename Json>
Json parse_json_or_discard(std::string_view text) {
  if (!check_json_nesting(text)) return Json(nlohmann::json::value_t::discarded);
  return Json::parse(text, nullptr, false);
}

template Result<nlohmann::json, Problem> parse_json(std::string_view, const nlohmann::json::parser_callback_t&);
template Result<nlohmann::ordered_json, Problem> parse_json(std::string_view,
                                                            const nlohmann::ordered_json::parser_callback_t&);
template nlohmann::json parse_json_or_discard(std::string_view);
template nlohmann::ordered_json parse_json_or_discard(std::string_view);

}  // namespace nacelle
