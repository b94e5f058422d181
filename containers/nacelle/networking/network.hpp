// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/clock_skews.hpp"
#include "nacelle/base/guarded.hpp"
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

/// Joins the robot to ROS 2's network. Reports the mode in force, or why the robot is not on the network.
///
/// The robot does not depend on it: errors are reported, and nothing local changes. While the robot is on the network,
/// or could not join, this class watches the machine's addresses and rejoins when they change. A join that failed is also
/// retried, after 1 s and then after pauses that grow to a minute.
/// Threads: one, except look(), and `say`, which the network's thread also calls.
class Network {
 public:
  using Say = std::function<void(const std::string& line)>;
  /// `graph`, `services` and `clock` must outlive this object. `clock_skews` receives the estimates of other machines'
  /// clocks.
  Network(launch::NetworkPlan plan, transport_dds::Environment environment, Graph& graph, ServiceGraph& services,
          const Clock& clock, Say say, std::shared_ptr<ClockSkews> clock_skews = nullptr);
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;
  ~Network();

  /// Sets the full name of the container's node. Some of its services are refused to remote callers
  /// (refused_services.hpp). Call it before start().
  void protect_services_of(std::string node) { node_ = std::move(node); }
  /// Sets a function that receives the problems of endpoints instead of `say`. The network's thread calls it. Call this
  /// before start().
  void tell_problems_to(std::function<void(const Problem&)> told) { told_ = std::move(told); }
  /// Joins according to launch file and environment, and reports remarks. If it cannot join, line() and state() give
  /// the reason. Errors: the launch file requests a network, and this program was built without one.
  [[nodiscard]] Result<void, Problem> start();
  /// Changes the mode by leaving the network and joining it again, so that peers discover all nodes again. On error it
  /// rejoins in the previous mode and returns the reason.
  [[nodiscard]] Result<void, Problem> show(launch::NetworkMode mode, const std::string& because_of);
  /// Returns the mode that `nacelle export off` sets: Off if launch file and environment request that, otherwise Local.
  [[nodiscard]] launch::NetworkMode unexported() const;

  /// Calls `at` with the nodes, topics and services of other participants (DdsMirror::look()). Does not call it if the
  /// network is not joined. Threads: any.
  void look(const std::function<void(const transport_dds::RemoteGraph&)>& at) const;
  /// Returns the number of this side's writers on the network.
  [[nodiscard]] std::uint64_t writer_count() const;

  /// Returns the last line of the bring-up's output; empty if the program was built without a network and none was
  /// requested.
  [[nodiscard]] std::string line() const;
  /// Returns the settings (network_wish.hpp), `running`, `problem`, nodes with the same name elsewhere, clock skews,
  /// and traffic counters.
  [[nodiscard]] nlohmann::json state() const;

  /// Returns a descriptor to poll for reading; -1: nothing is watched.
  [[nodiscard]] int descriptor() const { return watch_ ? watch_->descriptor() : -1; }
  [[nodiscard]] std::optional<MonotonicTime> next_due() const {
    return due_ && retry_ ? std::min(*due_, *retry_) : due_ ? due_ : retry_;
  }
  /// Retries a failed join. Call it after the wall clock was set: a certificate that was not valid may be valid now.
  void note_clock_jump();
  /// Rejoins after addresses have changed and then stayed unchanged for 500 ms, and retries a join that failed. `told`: the
  /// descriptor is readable.
  void serve(bool told);

 private:
  [[nodiscard]] Result<void, Problem> join();
  void leave();
  void watch_links();
  /// After a join that failed for a reason that may pass: sets the time of the next.
  void plan_retry();
  void retry();
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
  std::optional<Problem> why_not_;  // reason for not being on the network
  bool is_asked_for_ = false;       // explicitly, not only by default
  std::unique_ptr<LinkWatch> watch_;
  std::vector<NetworkLink> joined_with_;
  std::optional<MonotonicTime> due_, retry_;
  Duration retry_pause_{};  // the last one
  struct Joined;
  std::unique_ptr<Joined> joined_;    // null: not on the network
  Guarded<const DdsMirror*> mirror_;  // that of `joined_`, for look()
};

/// Tests whether a robot with these settings can join: joins briefly without sending or receiving. Returns the remarks.
/// In mode Off, or in a build without a network, it does nothing. Errors: the reason for which the network would be
/// off.
[[nodiscard]] Result<std::vector<Problem>, Problem> try_network(transport_dds::NetworkSettings settings);

}  // namespace nacelle::networking
