// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/clock_skews.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/host/graph.hpp"
#include "nacelle/host/service_graph.hpp"
#include "nacelle/launch/network_plan.hpp"
#include "networking/network_links.hpp"
#include "transport_dds/wire/network_settings.hpp"

namespace nacelle {
class DdsMirror;
namespace transport_dds {
class RemoteGraph;
}
}  // namespace nacelle

namespace nacelle::networking {

/// The robot on ROS 2's network: who can see it now, and the reason if it cannot join.
///
/// The robot does not depend on it: errors are reported, and nothing local changes. While it is on the network, or
/// could not join, the machine's addresses are watched, and it rejoins when they change.
/// Threads: one, but for `say`, which the network's thread calls too.
class Network {
 public:
  using Say = std::function<void(const std::string& line)>;
  /// `graph`, `services` and `clock` outlive it. `clock_skews` is kept up to date with the estimates of other machines'
  /// clocks.
  Network(launch::NetworkPlan plan, transport_dds::Environment environment, Graph& graph, ServiceGraph& services,
          const Clock& clock, Say say, std::shared_ptr<ClockSkews> clock_skews = nullptr);
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;
  ~Network();

  /// Sets the full name of the container's node, whose services are partly refused to remote callers
  /// (refused_services.hpp). Call before start().
  void protect_services_of(std::string node) { node_ = std::move(node); }
  /// Sets the receiver of problems of endpoints, instead of `say`; called on the network's thread. Call before start().
  void tell_problems_to(std::function<void(const Problem&)> told) { told_ = std::move(told); }
  /// Joins according to launch file and environment, and reports remarks. Errors: the launch file requests a network,
  /// and this program was built without.
  [[nodiscard]] Result<void, Problem> start();
  /// Changes the mode; peers discover all nodes again. On error the previous mode stays in force.
  [[nodiscard]] Result<void, Problem> show(launch::NetworkMode mode, const std::string& because_of);
  /// Returns the mode of `nacelle export off`: the launch file's mode, but never Export.
  [[nodiscard]] launch::NetworkMode unexported() const;

  /// Nodes, topics and services of other participants (DdsMirror::look()); not called where the network is not joined.
  void look(const std::function<void(const transport_dds::RemoteGraph&)>& at) const;
  /// Endpoints of this side on the network, now.
  [[nodiscard]] std::uint64_t writer_count() const;

  /// Returns the bring-up's last line; empty if the program was built without a network and none was requested.
  [[nodiscard]] std::string line() const;
  /// The settings (network_wish.hpp), `running`, `problem`, and what has crossed so far.
  [[nodiscard]] nlohmann::json state() const;

  /// Returns a descriptor to poll for reading; -1: nothing is watched.
  [[nodiscard]] int descriptor() const { return watch_ ? watch_->descriptor() : -1; }
  [[nodiscard]] std::optional<MonotonicTime> next_due() const { return due_; }
  /// Call after a jump of the wall clock: a certificate that was not valid may be valid now.
  void note_clock_jump();
  /// `told`: the descriptor is readable. Rejoins after addresses have changed and then stayed unchanged for a moment.
  void serve(bool told);

 private:
  [[nodiscard]] Result<void, Problem> join();
  void leave();
  void watch_links();
  [[nodiscard]] std::vector<NetworkLink> of_interest(std::vector<NetworkLink> links) const;

  launch::NetworkPlan plan_;
  const launch::NetworkPlan written_;  // as the launch file has it
  const transport_dds::Environment environment_;
  Graph& graph_;
  ServiceGraph& services_;
  const Clock& clock_;
  const Say say_;
  const std::shared_ptr<ClockSkews> clock_skews_;
  std::string node_;
  std::function<void(const Problem&)> told_;
  transport_dds::NetworkSettings settings_;
  std::optional<Problem> why_not_;  // it is not on the network, though it should be
  bool is_asked_for_ = false;       // explicitly, not only by default
  std::unique_ptr<LinkWatch> watch_;
  std::vector<NetworkLink> joined_with_;
  std::optional<MonotonicTime> due_;
  struct Joined;
  std::unique_ptr<Joined> joined_;  // null: not on the network
};

/// Tests whether a robot with these settings can join, by joining for a moment without sending or receiving. Returns what it
/// would remark on. Errors: why its network would be off. Off, or built without: nothing is done.
[[nodiscard]] Result<std::vector<Problem>, Problem> try_network(transport_dds::NetworkSettings settings);

}  // namespace nacelle::networking
