// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/launch/network_plan.hpp"
#include "nacelle/msgs/byte_message.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/runtime/broker.hpp"
#include "networking/network.hpp"
#include "remote/service_clients.hpp"
#include "requests/late_reply.hpp"
#include "transport_dds/wire/remote_graph.hpp"

namespace nacelle::remote {

struct RemoteOptions {
  std::optional<int> domain;                ///< None: ROS_DOMAIN_ID.
  std::optional<launch::NetworkMode> mode;  ///< None: as ROS 2's variables request, otherwise Export.
  Duration spin_time = 1s;                  ///< Time for discovery.
  std::vector<std::filesystem::path> message_folders;
};

/// Runs this process as a hidden ROS 2 node "/_nacelle_cli_<pid>", which discovers other nodes, reads and writes
/// topics, and calls services.
///
/// Threads: one.
class RemoteNetwork {
 public:
  /// Joins the network. Errors: invalid environment variables; a network that is off or cannot be joined.
  [[nodiscard]] static Result<std::unique_ptr<RemoteNetwork>, Problem> join(const RemoteOptions& options);
  RemoteNetwork(const RemoteNetwork&) = delete;
  RemoteNetwork& operator=(const RemoteNetwork&) = delete;
  /// Leaves the network after pending messages have been sent, for at most 500 ms. Peers are informed that the node
  /// ends. Precondition: readers and writers that were created here have been destroyed.
  ~RemoteNetwork();

  [[nodiscard]] const Clock& clock() const { return clock_; }
  [[nodiscard]] msgs::TypeLibrary& types() { return types_; }
  /// Returns the domain as text for users: "domain 5".
  [[nodiscard]] const std::string& where() const { return where_; }

  /// Sets descriptors that end a wait at once when one of them is readable. Call it before the first wait.
  void interrupted_by(std::vector<int> descriptors) { interrupts_ = std::move(descriptors); }
  /// Returns a descriptor that is readable after an event since the last wait() or drain(): a problem, a service that
  /// appeared or disappeared, an answer.
  [[nodiscard]] int descriptor() const { return bell_.descriptor(); }
  void drain();
  /// Blocks until `holds()` returns true, which is called after every event and every 10 ms. Returns false after the
  /// time limit, or if a descriptor of interrupted_by() is readable.
  [[nodiscard]] bool wait(MonotonicTime until, const std::function<bool()>& holds);
  /// Waits for discovery: for the spin time, counted from now, and a moment longer while a discovered participant has
  /// not announced its endpoints. Returns whether `holds()` became true.
  [[nodiscard]] bool find(const std::function<bool()>& holds);
  /// Waits for discovery of complete lists: for the spin time, counted from the join. What is unknown afterwards counts
  /// as absent. Returns early if `holds` returns true.
  void find_all(const std::function<bool()>& holds = [] { return false; });

  /// Returns the result of `see` for the remote graph. `see` must not call other members of this class: the network's
  /// thread is blocked meanwhile.
  template <typename F>
  [[nodiscard]] auto look(F see) const {
    std::optional<decltype(see(std::declval<const transport_dds::RemoteGraph&>()))> seen;
    network_->look([&](const auto& graph) { seen = see(graph); });
    return std::move(*seen);
  }

  /// Returns the specification of an endpoint of this node.
  [[nodiscard]] EndpointSpec spec_of(std::string topic, const msgs::MessageType& type, const QoS& qos) const;
  [[nodiscard]] Transport& transport() { return broker_; }
  /// Returns why an endpoint that was created here is not on the network, if known. `where`: a topic, or "service " and
  /// a name.
  [[nodiscard]] std::optional<Problem> problem_of(const std::string& where) const;
  /// Returns a type whose messages are bytes. Valid as long as this object.
  [[nodiscard]] const msgs::MessageType& bytes_of(const std::string& type, const std::string& hash);

  /// Starts a call as runtime::Container::call_service() does, for a remote server. Waits for the server at most for
  /// the spin time, and a moment longer for one that was discovered.
  /// Errors: no server offers the service, or not with that type, or with another middleware's protocol.
  [[nodiscard]] Result<std::unique_ptr<runtime::ServiceCall>, Problem> start_call(const std::string& service,
                                                                                  const msgs::ServiceType& type,
                                                                                  void* request,
                                                                                  std::function<void()> on_answer);
  /// Creates the client of a service ahead of the call, so that several clients discover their servers at the same
  /// time. Errors: an unknown type.
  [[nodiscard]] Result<void, Problem> prepare(const std::string& service, const char* type);

 private:
  explicit RemoteNetwork(const RemoteOptions& options);
  [[nodiscard]] Result<void, Problem> start(const RemoteOptions& options);
  [[nodiscard]] bool find_until(MonotonicTime until, const std::function<bool()>& holds);
  void note(const Problem& problem);
  [[nodiscard]] Problem why_not(const std::string& service, const msgs::ServiceType& type) const;

  const SystemClock clock_;
  const Duration spin_time_;
  const std::string node_;
  std::string where_;
  MonotonicTime found_by_;
  std::vector<int> interrupts_;
  Bell bell_;
  msgs::TypeLibrary types_;
  std::map<std::pair<std::string, std::string>, std::unique_ptr<msgs::ByteMessageType>> byte_types_;
  Guarded<std::vector<Problem>> problems_;  // of endpoints, and of services that cannot be called
  runtime::Broker broker_{clock_};
  ServiceClients clients_;
  std::unique_ptr<networking::Network> network_;  // destroyed first: its threads use the members above
};

}  // namespace nacelle::remote
