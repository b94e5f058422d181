// SPDX-License-Identifier: Apache-2.0
#include "proof/declared_graph.hpp"

#include <algorithm>
#include <tuple>

#include "nacelle/base/guarded.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::proof {
namespace {

/// Collects the endpoints that are reported when it joins; later events are ignored.
class Snapshot final : public GraphListener {
 public:
  void on_made(const EndpointInfo& endpoint) noexcept override {
    const EndpointSpec& spec = endpoint.spec;
    if (spec.node.empty()) return;
    endpoints_.lock()->push_back({spec.node, spec.topic, spec.type == nullptr ? "" : spec.type->name,
                                  endpoint.is_writer, spec.qos.resolved(),
                                  spec.command_timeout.after > Duration::zero(), spec.via != 0});
  }
  void on_gone(std::uint64_t) noexcept override {}
  void on_gate(std::uint64_t, bool) noexcept override {}
  void on_life(std::uint64_t) noexcept override {}
  void on_left(std::uint64_t) noexcept override {}
  [[nodiscard]] std::vector<Endpoint> take() { return std::move(*endpoints_.lock()); }

 private:
  Guarded<std::vector<Endpoint>> endpoints_;
};

}  // namespace

std::vector<Endpoint> endpoints_of(Graph& graph) {
  Snapshot snapshot;
  graph.leave(graph.join(snapshot));
  std::vector<Endpoint> endpoints = snapshot.take();
  const auto rank = [](const Endpoint& e) { return std::tuple(e.topic, !e.publishes, e.node, e.type); };
  std::ranges::stable_sort(endpoints, [&](const Endpoint& a, const Endpoint& b) { return rank(a) < rank(b); });
  return endpoints;
}

}  // namespace nacelle::proof
