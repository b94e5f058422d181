// SPDX-License-Identifier: Apache-2.0
#include "proof/drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "drawing/graphviz.hpp"
#include "nacelle/host/action_names.hpp"
#include "nacelle/qos/text.hpp"

namespace nacelle::proof {
namespace {

/// A line of a node's box.
struct Port {
  std::string topic, type, qos;
  bool publishes = false, is_bad = false, meets_another = false;
};

std::map<std::string, std::vector<Port>> boxes_of(const std::vector<Endpoint>& endpoints,
                                                  const std::vector<std::string>& bad) {
  std::map<std::string, std::vector<Port>> boxes;
  for (const Endpoint& endpoint : endpoints) {
    // An action's feedback stands for all of it, and goes from the server to the client.
    const auto action = action::action_of_topic(endpoint.topic, endpoint.type);
    if (!action && action::is_action_part(endpoint.topic)) continue;
    const bool is_bad = std::ranges::find(bad, endpoint.topic + " " + endpoint.node) != bad.end();
    const bool meets = std::ranges::any_of(endpoints, [&](const Endpoint& other) {
      return other.topic == endpoint.topic && other.publishes != endpoint.publishes;
    });
    boxes[endpoint.node].push_back({action ? action->name : endpoint.topic, action ? action->type : endpoint.type,
                                    to_text(endpoint.qos), endpoint.publishes, is_bad, meets});
  }
  for (auto& [node, ports] : boxes) std::ranges::stable_sort(ports, {}, &Port::publishes);
  return boxes;
}

std::string row_of(const Port& port, std::size_t number) {
  const char* const ink = port.is_bad ? "red" : port.meets_another ? "black" : "#888888";
  const char* const side = port.publishes ? "right" : "left";
  return fmt::format(
      "<tr><td port=\"p{}\" align=\"{}\" balign=\"{}\"><font color=\"{}\">{}</font><br/><font color=\"{}\" "
      "point-size=\"8\">{}<br/>{}</font></td></tr>",
      number, side, side, ink, drawing::dot_label_text(port.topic), port.is_bad ? ink : "#666666",
      drawing::dot_label_text(port.type), drawing::dot_label_text(port.qos));
}

}  // namespace

std::string to_dot(const std::vector<Endpoint>& endpoints, const std::vector<std::string>& bad) {
  const auto boxes = boxes_of(endpoints, bad);
  std::string out =
      "digraph pipeline {\n  rankdir=LR; ranksep=1.5; nodesep=0.3;\n"
      "  node [shape=plain, fontname=\"Helvetica\", fontsize=11];\n  edge [color=\"#777777\", arrowsize=0.6];\n";
  struct End {
    std::string place;
    const Port* port;
  };
  std::map<std::string, std::vector<End>> readers, writers;
  std::size_t number = 0;
  for (const auto& [node, ports] : boxes) {
    out += fmt::format(
        "  n{} [label=<<table border=\"0\" cellborder=\"1\" cellspacing=\"0\" cellpadding=\"4\"><tr><td "
        "bgcolor=\"#fdf8e8\"><b>{}</b></td></tr>",
        number, drawing::dot_label_text(node));
    for (std::size_t i = 0; i < ports.size(); ++i) {
      out += row_of(ports[i], i);
      (ports[i].publishes ? writers : readers)[ports[i].topic].push_back(
          {fmt::format("n{}:p{}:{}", number, i, ports[i].publishes ? 'e' : 'w'), &ports[i]});
    }
    out += "</table>>];\n";
    ++number;
  }
  for (const auto& [topic, from] : writers) {
    for (const End& writer : from) {
      for (const End& reader : readers[topic])
        out += fmt::format("  {} -> {} [tooltip={}{}];\n", writer.place, reader.place, drawing::dot_quoted(topic),
                           writer.port->is_bad && reader.port->is_bad ? ", color=red" : "");
    }
  }
  return out + "}\n";
}

}  // namespace nacelle::proof
