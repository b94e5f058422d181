// SPDX-License-Identifier: Apache-2.0
#include "drawing/frame_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "drawing/graphviz.hpp"
#include "nacelle/base/printable.hpp"

namespace nacelle::drawing {
namespace {

constexpr double kStale_s = 1.0;  // an edge that is older is drawn red: its owner has fallen silent

bool is_stale(const FrameEdge& edge) { return !edge.is_static && std::abs(edge.age_s) > kStale_s; }

/// A frame with its place in the forest.
struct Twig {
  std::string name;
  const FrameEdge* edge = nullptr;  // to its parent; null: a root
  std::size_t depth = 0;
  std::vector<std::size_t> children;
};

/// The frames, each parent before its children, which stand by name. Roots are those at depth 0.
std::vector<Twig> forest_of(const std::vector<FrameEdge>& edges) {
  std::map<std::string, std::map<std::string, const FrameEdge*>> below;
  std::set<std::string> names, children;
  for (const auto& edge : edges) {
    below[edge.parent][edge.child] = &edge;
    names.insert({edge.parent, edge.child});
    children.insert(edge.child);
  }
  std::vector<Twig> twigs;
  std::set<std::string> seen;
  const std::function<std::size_t(const std::string&, const FrameEdge*, std::size_t)> grow =
      [&](const std::string& name, const FrameEdge* edge, std::size_t depth) {
        const std::size_t here = twigs.size();
        twigs.push_back({name, edge, depth, {}});
        seen.insert(name);
        for (const auto& [child, to_it] : below[name]) {
          if (seen.count(child) != 0) continue;
          const std::size_t twig = grow(child, to_it, depth + 1);
          twigs[here].children.push_back(twig);
        }
        return here;
      };
  for (const auto& name : names) {
    if (children.count(name) == 0) grow(name, nullptr, 0);
  }
  for (const auto& name : names) {
    if (seen.count(name) == 0) grow(name, nullptr, 0);  // a circle
  }
  return twigs;
}

}  // namespace

std::string short_time(double seconds) {
  if (std::abs(seconds) < 1.0) return fmt::format("{:.0f} ms", seconds * 1e3);
  if (std::abs(seconds) < 120.0) return fmt::format("{:.1f} s", seconds);
  return fmt::format("{:.0f} min", seconds / 60);
}

std::string describe(const FrameEdge& edge) {
  const std::string owner = edge.owner.empty() ? "owner unknown" : printable_line(edge.owner);
  if (edge.is_static) return "static, " + owner;
  return fmt::format("{:.1f} Hz, {} old, {}", edge.rate_hz, short_time(edge.age_s), owner);
}

std::string tree_text(const std::vector<FrameEdge>& edges) {
  const std::vector<Twig> twigs = forest_of(edges);
  std::vector<std::pair<std::string, const FrameEdge*>> lines;
  std::vector<std::size_t> letters;  // of each line: a box character is three bytes
  const std::function<void(std::size_t, const std::string&, std::size_t, bool)> write =
      [&](std::size_t i, const std::string& before, std::size_t wide, bool is_last) {
        const bool is_root = twigs[i].edge == nullptr;
        const std::string name = printable_line(twigs[i].name);
        lines.emplace_back(before + (is_root ? "" : is_last ? "└─ " : "├─ ") + name, twigs[i].edge);
        letters.push_back(wide + (is_root ? 0 : 3) + name.size());
        for (std::size_t n = 0; n < twigs[i].children.size(); ++n)
          write(twigs[i].children[n],
                before + (is_root   ? ""
                          : is_last ? "   "
                                    : "│  "),
                wide + (is_root ? 0 : 3), n + 1 == twigs[i].children.size());
      };
  for (std::size_t i = 0; i < twigs.size(); ++i) {
    if (twigs[i].depth == 0) write(i, "", 0, true);
  }
  std::size_t widest = 0;
  for (const std::size_t wide : letters) widest = std::max(widest, wide);
  std::string out;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    out += lines[i].first;
    if (lines[i].second != nullptr) out += std::string(widest - letters[i] + 2, ' ') + describe(*lines[i].second);
    out += '\n';
  }
  return out;
}

std::string tree_dot(const std::vector<FrameEdge>& edges) {
  std::string out = "digraph frames {\n  rankdir=LR;\n  node [shape=box, fontname=\"sans-serif\"];\n";
  for (const Twig& twig : forest_of(edges)) {
    out += fmt::format("  {};\n", dot_quoted(twig.name));
    if (twig.edge == nullptr) continue;
    out += fmt::format("  {} -> {} [label={}{}];\n", dot_quoted(twig.edge->parent), dot_quoted(twig.name),
                       dot_quoted(describe(*twig.edge)), is_stale(*twig.edge) ? ", color=red, fontcolor=red" : "");
  }
  return out + "}\n";
}

}  // namespace nacelle::drawing
