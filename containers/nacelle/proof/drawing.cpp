// SPDX-License-Identifier: Apache-2.0
#include "nacelle/proof/drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "nacelle/node/action_names.hpp"
#include "nacelle/qos/text.hpp"

namespace nacelle::proof {
namespace {

// Of the SVG, in pixels of a 1:1 view. A character of 12 px is at most 7 wide, one of 10 px at most 6.
constexpr int kName = 7, kSmall = 6, kTitleHigh = 26, kLineHigh = 18, kGap = 24, kColumnGap = 140, kMargin = 20;

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

void set_columns(Drawing& drawing) {
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

/// An end of a stream: a line of its node's box, with a dot at the side that the stream leaves or enters.
struct Port {
  std::size_t topic = 0;
  std::string label;
  bool publishes = false, bad = false, connected = false;
  int x = 0, y = 0;  ///< Of the dot.
};
struct Box {
  std::size_t node = 0;
  int x = 0, y = 0, width = 0, height = 0;
  std::vector<Port> ports;  ///< What it reads, then what it publishes.
};

std::vector<Box> boxes_of(const Drawing& drawing) {
  std::vector<Box> boxes;
  for (std::size_t node = 0; node < drawing.vertices.size(); ++node) {
    if (drawing.vertices[node].is_topic) continue;
    Box box{node, 0, 0, static_cast<int>(drawing.vertices[node].name.size()) * kName + 24, 0, {}};
    for (const bool publishes : {false, true}) {
      for (const auto& edge : drawing.edges) {
        if ((publishes ? edge.from : edge.to) != node) continue;
        const std::size_t topic = publishes ? edge.to : edge.from;
        const bool connected = std::ranges::any_of(
            drawing.edges, [&](const auto& other) { return publishes ? other.from == topic : other.to == topic; });
        box.ports.push_back({topic, edge.label, publishes, edge.bad, connected, 0, 0});
        const auto wide = drawing.vertices[topic].name.size() * kName + edge.label.size() * kSmall + 40;
        box.width = std::max(box.width, static_cast<int>(wide));
      }
    }
    box.height = kTitleHigh + static_cast<int>(box.ports.size()) * kLineHigh + 6;
    boxes.push_back(std::move(box));
  }
  // Nodes stand in every second column of the graph, topics between them.
  std::map<int, int> widths, bottoms, lefts;
  for (const Box& box : boxes) {
    int& width = widths[drawing.vertices[box.node].column];
    width = std::max(width, box.width);
  }
  int x = kMargin;
  for (const auto& [column, width] : widths) {
    lefts[column] = x;
    x += width + kColumnGap;
  }
  for (Box& box : boxes) {
    const int column = drawing.vertices[box.node].column;
    int& bottom = bottoms.emplace(column, kMargin).first->second;
    box.x = lefts[column];
    box.y = bottom;
    box.width = widths[column];
    bottom += box.height + kGap;
    int y = box.y + kTitleHigh + kLineHigh / 2;
    for (Port& port : box.ports) {
      port.x = port.publishes ? box.x + box.width : box.x;
      port.y = y;
      y += kLineHigh;
    }
  }
  return boxes;
}

std::string curve(const Port& from, const Port& to) {
  const int bend = std::max(50, std::abs(to.x - from.x) / 2);
  return fmt::format("<path d=\"M{},{} C{},{} {},{} {},{}\" fill=\"none\" stroke=\"{}\"/>\n", from.x, from.y,
                     from.x + bend, from.y, to.x - bend, to.y, to.x, to.y, from.bad && to.bad ? "crimson" : "#999");
}

}  // namespace

Drawing draw(const std::vector<Endpoint>& endpoints, const std::vector<std::string>& bad) {
  Drawing drawing;
  std::map<std::pair<bool, std::string>, std::size_t> known;
  const auto vertex = [&](bool is_topic, const std::string& name) {
    const auto [found, is_new] = known.emplace(std::pair{is_topic, name}, drawing.vertices.size());
    if (is_new) drawing.vertices.push_back({name, "", is_topic, 0});
    return found->second;
  };
  for (const auto& endpoint : endpoints) {
    // An action is one thing; its feedback stands for all of it, and goes from the server to the client.
    const auto action = action::action_of_topic(endpoint.topic, endpoint.type);
    if (!action && action::is_action_part(endpoint.topic)) continue;
    const std::string &name = action ? action->name : endpoint.topic, &type = action ? action->type : endpoint.type;
    const std::size_t node = vertex(false, endpoint.node), topic = vertex(true, name);
    auto& detail = drawing.vertices[topic].detail;
    if (detail.find(type) == std::string::npos) detail += (detail.empty() ? "" : ", ") + type;
    const bool is_bad = std::ranges::find(bad, endpoint.topic + " " + endpoint.node) != bad.end();
    drawing.edges.push_back(
        {endpoint.publishes ? node : topic, endpoint.publishes ? topic : node, to_text(endpoint.qos), is_bad});
  }
  set_columns(drawing);
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
  const std::vector<Box> boxes = boxes_of(drawing);
  int wide = 2 * kMargin, high = 2 * kMargin;
  for (const Box& box : boxes) {
    wide = std::max(wide, box.x + box.width + kMargin);
    high = std::max(high, box.y + box.height + kMargin);
  }
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      wide, high);
  for (const Box& writer : boxes) {
    for (const Port& from : writer.ports) {
      if (!from.publishes) continue;
      for (const Box& reader : boxes) {
        for (const Port& to : reader.ports) {
          if (!to.publishes && to.topic == from.topic) out += curve(from, to);
        }
      }
    }
  }
  for (const Box& box : boxes) {
    out += fmt::format(
        "<rect x=\"{0}\" y=\"{1}\" width=\"{2}\" height=\"{3}\" rx=\"4\" fill=\"#fdf8e8\" stroke=\"black\"/>\n"
        "<text x=\"{4}\" y=\"{5}\" text-anchor=\"middle\" font-weight=\"bold\">{6}</text>\n",
        box.x, box.y, box.width, box.height, box.x + box.width / 2, box.y + 18,
        escaped(drawing.vertices[box.node].name));
    for (const Port& port : box.ports) {
      const auto& topic = drawing.vertices[port.topic];
      const char* const ink = port.bad ? "crimson" : "black";
      // The QoS beside the name, at the end that the stream leaves or enters; the type when one points at it.
      out += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"3\" fill=\"{}\" stroke=\"{}\"/>\n", port.x, port.y,
                         port.connected ? ink : "white", ink);
      out += fmt::format(
          "<text x=\"{}\" y=\"{}\" text-anchor=\"{}\" fill=\"{}\"><title>{}</title>{} <tspan font-size=\"10\" "
          "fill=\"{}\">{}</tspan></text>\n",
          port.publishes ? port.x - 10 : port.x + 10, port.y + 4, port.publishes ? "end" : "start", ink,
          escaped(topic.detail), escaped(topic.name), port.bad ? ink : "#666", escaped(port.label));
    }
  }
  return out + "</svg>\n";
}

}  // namespace nacelle::proof
