// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "nacelle/base/problem.hpp"

namespace nacelle {

/// {"where", "what", "way_out"} as texts, and as far as they are known "code", "value", "file", "line", "column", "node", "parameter".
/// For nlohmann::json: `json(problem)`.
inline void to_json(nlohmann::json& out, const Problem& problem) {
  const Place& at = problem.where;
  out = {{"where", at.text()}, {"what", problem.what}, {"way_out", problem.way_out}};
  const auto add = [&](const char* key, const std::string& text) {
    if (!text.empty()) out[key] = text;
  };
  add("code", problem.code.text());
  add("value", problem.value);
  add("words", at.text() == at.words ? std::string{} : at.words);
  add("file", at.file);
  add("node", at.node);
  add("parameter", at.parameter);
  if (at.line > 0) out["line"] = at.line;
  if (at.column > 0) out["column"] = at.column;
}

/// Reads what to_json() wrote; what is missing stays empty. `json.get<Problem>()`. Throws nlohmann's exceptions.
inline void from_json(const nlohmann::json& in, Problem& problem) {
  const auto text = [&](const char* key) { return in.value(key, std::string{}); };
  Place& at = problem.where;
  at.file = text("file");
  at.line = in.value("line", 0);
  at.column = in.value("column", 0);
  at.node = text("node");
  at.parameter = text("parameter");
  at.words = at.empty() ? text("where") : text("words");
  problem.what = text("what");
  problem.way_out = text("way_out");
  problem.code = ProblemCode::from_text(text("code"));
  problem.value = text("value");
}

}  // namespace nacelle
