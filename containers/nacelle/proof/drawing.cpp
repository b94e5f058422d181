// SPDX-License-Identifier: Apache-2.0
#include "nacelle/proof/drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "nacelle/qos/text.hpp"

namespace nacelle::proof {
namespace {

// Of the SVG, in pixels of a 1:1 view. A character of the font is at most 7 wide.
constexpr int kCharacter = 7, kHigh = 40, kRowStep = 66, kColumnGap = 190, kMargin = 20;

enum class Mark : char { New, Open, Done };

/// Which edges lead back to where one came from; without them the graph has no circle.
std::vector<bool> edges_back(const Drawing& drawing) {
  std::vector<bool> back(drawing.edges.size(), false);
  std::vector<Mark> marks(drawing.vertices.size(), Mark::New);
  // A stack of its own: a hostile launch file may be deep.
  struct Visit {
    std::size_t vertex, next_edge;
  };
  for (std::size_t start = 0; start < drawing.vertices.size(); ++start) {
    if (marks[start] != Mark::New) continue;
    std::vector<Visit> path{{start, 0}};
    marks[start] = Mark::Open;
    while (!path.empty()) {
      Visit& visit = path.back();
      if (visit.next_edge == drawing.edges.size()) {
        marks[visit.vertex] = Mark::Done;
        path.pop_back();
        continue;
      }
      const std::size_t index = visit.next_edge++;
      const auto& edge = drawing.edges[index];
      if (edge.from != visit.vertex) continue;
      if (marks[edge.to] == Mark::Open) {
        back[index] = true;
      } else if (marks[edge.to] == Mark::New) {
        marks[edge.to] = Mark::Open;
        path.push_back({edge.to, 0});
      }
    }
  }
  return back;
}

void lay_out(Drawing& drawing) {
  const std::vector<bool> back = edges_back(drawing);
  // The longest way from a source; without circles it settles within as many rounds as there are vertices.
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < drawing.edges.size(); ++i) {
      const auto& edge = drawing.edges[i];
      const int least = drawing.vertices[edge.from].column + 1;
      if (back[i] || drawing.vertices[edge.to].column >= least) continue;
      drawing.vertices[edge.to].column = least;
      changed = true;
    }
  }
  std::map<int, int> used;
  for (auto& vertex : drawing.vertices) vertex.row = used[vertex.column]++;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '&': out += "&amp;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out;
}

int width_of(const Drawing::Vertex& vertex) {
  return static_cast<int>(std::max(vertex.name.size(), vertex.detail.size())) * kCharacter + 24;
}

}  // namespace

Drawing draw(const std::vector<Endpoint>& endpoints, const std::vector<std::string>& bad) {
  Drawing drawing;
  std::map<std::pair<bool, std::string>, std::size_t> known;
  const auto vertex = [&](bool is_topic, const std::string& name) {
    const auto [found, is_new] = known.emplace(std::pair{is_topic, name}, drawing.vertices.size());
    if (is_new) drawing.vertices.push_back({name, "", is_topic, 0, 0});
    return found->second;
  };
  for (const auto& endpoint : endpoints) {
    const std::size_t node = vertex(false, endpoint.node), topic = vertex(true, endpoint.topic);
    auto& detail = drawing.vertices[topic].detail;
    if (detail.find(endpoint.type) == std::string::npos) detail += (detail.empty() ? "" : ", ") + endpoint.type;
    const bool is_bad = std::ranges::find(bad, endpoint.topic + " " + endpoint.node) != bad.end();
    drawing.edges.push_back(
        {endpoint.publishes ? node : topic, endpoint.publishes ? topic : node, to_text(endpoint.qos), is_bad});
  }
  lay_out(drawing);
  return drawing;
}

std::string to_dot(const Drawing& drawing) {
  std::string out = "digraph pipeline {\n  rankdir=LR;\n  node [fontname=\"sans-serif\"];\n";
  for (std::size_t i = 0; i < drawing.vertices.size(); ++i) {
    const auto& vertex = drawing.vertices[i];
    out += fmt::format("  v{} [shape={}, label={}];\n", i, vertex.is_topic ? "ellipse" : "box",
                       quoted(vertex.name + (vertex.detail.empty() ? "" : "\n" + vertex.detail)));
  }
  for (const auto& edge : drawing.edges)
    out += fmt::format("  v{} -> v{} [label={}{}];\n", edge.from, edge.to, quoted(edge.label),
                       edge.bad ? ", color=red, fontcolor=red" : "");
  return out + "}\n";
}

std::string to_svg(const Drawing& drawing) {
  std::map<int, int> widths;
  int rows = 0;
  for (const auto& vertex : drawing.vertices) {
    widths[vertex.column] = std::max(widths[vertex.column], width_of(vertex));
    rows = std::max(rows, vertex.row + 1);
  }
  std::map<int, int> left;
  int wide = kMargin;
  for (const auto& [column, width] : widths) {
    left[column] = wide;
    wide += width + kColumnGap;
  }
  wide += kMargin - (widths.empty() ? 0 : kColumnGap);
  const auto x_of = [&](const Drawing::Vertex& v) { return left[v.column]; };
  const auto y_of = [&](const Drawing::Vertex& v) { return kMargin + v.row * kRowStep; };

  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n"
      "<defs><marker id=\"tip\" viewBox=\"0 0 8 8\" refX=\"8\" refY=\"4\" markerWidth=\"8\" markerHeight=\"8\" "
      "orient=\"auto\"><path d=\"M0,0 L8,4 L0,8 z\"/></marker></defs>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      wide, rows * kRowStep + 2 * kMargin);
  // Labels of edges into one vertex would cover each other: they stand at the end where there is one edge per line.
  for (const auto& edge : drawing.edges) {
    const auto& from = drawing.vertices[edge.from];
    const auto& to = drawing.vertices[edge.to];
    const int x1 = x_of(from) + width_of(from), y1 = y_of(from) + kHigh / 2;
    const int x2 = x_of(to), y2 = y_of(to) + kHigh / 2;
    const int bend = std::max(60, std::abs(x2 - x1) / 2);
    const char* const colour = edge.bad ? "crimson" : "#777";
    out += fmt::format(
        "<path d=\"M{},{} C{},{} {},{} {},{}\" fill=\"none\" stroke=\"{}\" marker-end=\"url(#tip)\"><title>{} to {}: "
        "{}</title></path>\n",
        x1, y1, x1 + bend, y1, x2 - bend, y2, x2, y2, colour, escaped(from.name), escaped(to.name),
        escaped(edge.label));
    // A quarter of the way from the node's end: of the curve's points there, t = 0.25 or 0.75.
    const double t = from.is_topic ? 0.75 : 0.25, u = 1 - t;
    const double x = u * u * u * x1 + 3 * u * u * t * (x1 + bend) + 3 * u * t * t * (x2 - bend) + t * t * t * x2;
    const double y = u * u * u * y1 + 3 * u * u * t * y1 + 3 * u * t * t * y2 + t * t * t * y2;
    out += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" font-size=\"9\" text-anchor=\"middle\" fill=\"{}\">{}</text>\n",
                       x, y - 3, colour, escaped(edge.label));
  }
  for (const auto& vertex : drawing.vertices) {
    const int x = x_of(vertex), y = y_of(vertex), w = width_of(vertex);
    out += fmt::format(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" rx=\"{}\" fill=\"{}\" stroke=\"black\"/>\n"
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
        x, y, w, kHigh, vertex.is_topic ? kHigh / 2 : 4, vertex.is_topic ? "#eef4fb" : "#fdf3d8", x + w / 2,
        y + (vertex.detail.empty() ? 24 : 17), escaped(vertex.name));
    if (!vertex.detail.empty())
      out += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" font-size=\"10\" fill=\"#555\">{}</text>\n",
                         x + w / 2, y + 32, escaped(vertex.detail));
  }
  return out + "</svg>\n";
}

}  // namespace nacelle::proof
