// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/host/graph.hpp"
#include "nacelle/host/node_host.hpp"

namespace nacelle {

/// Returns a QoS for a reader that fits all of these publishers: best_effort if one of them is, with history if all of them keep one. As deep
/// as their queues together, within these bounds.
[[nodiscard]] inline QoS reader_qos(const std::vector<QoS>& offered, std::size_t least_depth, std::size_t most_depth) {
  const auto all = [&](auto holds) { return std::all_of(offered.begin(), offered.end(), holds); };
  std::size_t depth = 0;
  for (const QoS& one : offered) depth += one.resolved().queue_capacity();
  QoS qos{std::clamp(depth, least_depth, most_depth)};
  qos.best_effort();
  if (all([](const QoS& one) { return one.resolved().reliability() == Reliability::Reliable; })) qos.reliable();
  if (all([](const QoS& one) { return one.resolved().durability() == Durability::TransientLocal; }))
    qos.transient_local();
  return qos;
}

/// Readers and writers of topics whose names and types are known at run time only, as a recorder and a player need them:
/// `GenericTopics topics{host(), get_fully_qualified_name()}`.
///
/// Names are full and remapped (Node::resolve_topic_name()). The host outlives this object and what it makes. Threads: any, except write().
class GenericTopics {
 public:
  GenericTopics(NodeHost& host, std::string node) : host_(host), node_(std::move(node)) {}

  [[nodiscard]] const Clock& clock() const { return host_.clock(); }
  [[nodiscard]] const std::string& node() const { return node_; }
  /// Tells the listener of all endpoints of the container and of each change, until the handle goes. Those of other processes are among them
  /// as far as somebody here reads or writes their topic.
  [[nodiscard]] std::unique_ptr<GraphWatchHandle> watch(GraphListener& listener) { return host_.watch_graph(listener); }
  /// Returns a reader for a thread of the component's own; the listener outlives it. The node's lifecycle gate does not close it.
  [[nodiscard]] std::unique_ptr<Reader> read(const std::string& topic, const msgs::MessageType& type, const QoS& qos,
                                             ReadyListener& listener) {
    return host_.create_reader(spec(topic, type, qos), listener);
  }
  /// Returns a writer behind the node's lifecycle gate. Threads: the component's executor.
  [[nodiscard]] std::unique_ptr<Writer> write(const std::string& topic, const msgs::MessageType& type, const QoS& qos) {
    return host_.create_writer(spec(topic, type, qos));
  }

 private:
  [[nodiscard]] EndpointSpec spec(const std::string& topic, const msgs::MessageType& type, const QoS& qos) const {
    EndpointSpec made;
    made.topic = topic;
    made.type = &type;
    made.qos = qos;
    made.node = node_;
    return made;
  }

  NodeHost& host_;
  std::string node_;
};

}  // namespace nacelle
