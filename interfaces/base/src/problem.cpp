// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/problem.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "nacelle/base/printable.hpp"

namespace nacelle {
namespace {

constexpr std::size_t kLongestName = 1000;  // bytes; distance() takes time and memory in proportion to the product

std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

/// "port_name" for "port": only the first word was written.
std::string shortest_with_prefix(std::string_view wrong, const std::vector<std::string>& candidates) {
  std::string best;
  for (const auto& candidate : candidates) {
    if (wrong.size() < 3 || candidate.size() <= wrong.size() || !candidate.starts_with(wrong)) continue;
    if (std::string_view{"_./"}.find(candidate[wrong.size()]) == std::string_view::npos) continue;
    if (best.empty() || candidate.size() < best.size()) best = candidate;
  }
  return best;
}

}  // namespace

Place Place::of_node(std::string node) { return of_parameter("", std::move(node)); }

Place Place::of_parameter(std::string parameter, std::string node) {
  Place place;
  place.node = std::move(node);
  place.parameter = std::move(parameter);
  return place;
}

std::string Place::text() const {
  std::string all;
  if (!node.empty()) all = "node " + node;
  if (!parameter.empty()) all += (all.empty() ? "parameter " : ", parameter ") + parameter;
  const std::string rest = file.empty() ? words : line > 0 ? file + ":" + std::to_string(line) : file;
  if (!all.empty() && !rest.empty()) all += ": ";
  return all + rest;
}

ProblemCode ProblemCode::from_text(std::string text) {
  ProblemCode code;
  code.text_ = std::move(text);
  return code;
}

std::string Problem::text() const {
  std::string all;
  if (!where.empty()) all += where.text() + ": ";
  all += what;
  if (!way_out.empty()) all += "; " + way_out;
  return printable(all);
}

std::string nearest_name(std::string_view wrong, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t best_distance = 0;
  for (const auto& candidate : candidates) {
    const std::size_t near = std::max<std::size_t>(1, std::max(wrong.size(), candidate.size()) / 3);
    // At least the difference of the lengths, whatever the texts; names from outside may have megabytes, and no two of those.
    const std::size_t least = std::max(wrong.size(), candidate.size()) - std::min(wrong.size(), candidate.size());
    if (least > near || std::min(wrong.size(), candidate.size()) > kLongestName) continue;
    const std::size_t d = distance(wrong, candidate);
    if (d > near) continue;
    if (best.empty() || d < best_distance) {
      best = candidate;
      best_distance = d;
    }
  }
  return best;
}

std::string suggestion(std::string_view wrong, const std::vector<std::string>& candidates) {
  if (const auto near = nearest_name(wrong, candidates); !near.empty())
    return "did you mean '" + printable_line(near) + "'?";
  if (const auto whole = shortest_with_prefix(wrong, candidates); !whole.empty())
    return "did you mean '" + printable_line(whole) + "'?";
  std::vector<std::string> choices;
  for (const auto& candidate : candidates) {
    std::string choice = printable_line(candidate);
    // A topic with two types comes twice.
    if (std::find(choices.begin(), choices.end(), choice) == choices.end()) choices.push_back(std::move(choice));
  }
  if (choices.empty()) return {};
  return (choices.size() == 1 ? "the only choice is " : "one of ") + join(choices);
}

std::string join(const std::vector<std::string>& parts, std::string_view separator) {
  std::string all;
  for (const auto& part : parts) {
    if (!all.empty()) all += separator;
    all += part;
  }
  return all;
}

}  // namespace nacelle
