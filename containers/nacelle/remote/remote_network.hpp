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
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/runtime/broker.hpp"
#include "networking/network.hpp"
#include "remote/byte_message.hpp"
#include "remote/service_clients.hpp"
#include "requests/late_reply.hpp"
#include "transport_dds/wire/remote_graph.hpp"

namespace nacelle::remote {

struct RemoteOptions {
  std::optional<int> domain;                ///< None: ROS_DOMAIN_ID.
  std::optional<launch::NetworkMode> mode;  ///< None: as ROS 2's variables ask, else Export.
  Duration spin_time = 1s;                  ///< For discovery.
  std::vector<std::filesystem::path> message_folders;
};

/// This process as a hidden ROS 2 node "/_nacelle_cli_<pid>": it finds others, reads and writes topics, calls services.
///
/// Threads: one.
class RemoteNetwork {
 public:
  /// Errors: variables that cannot be obeyed; a network that is off, or cannot be had.
  [[nodiscard]] static Result<std::unique_ptr<RemoteNetwork>, Problem> join(const RemoteOptions& options);
  RemoteNetwork(const RemoteNetwork&) = delete;
  RemoteNetwork& operator=(const RemoteNetwork&) = delete;
  /// Messages published before are still sent, and peers are informed that the node ends. Precondition: readers and
  /// writers made here have ended.
  ~RemoteNetwork();

  [[nodiscard]] const Clock& clock() const { return clock_; }
  [[nodiscard]] msgs::TypeLibrary& types() { return types_; }
  /// "domain 5", for people.
  [[nodiscard]] const std::string& where() const { return where_; }

  /// Waits return at once when one of these is readable. Set it before the first wait.
  void interrupted_by(std::vector<int> descriptors) { interrupts_ = std::move(descriptors); }
  /// Readable when a problem has been found since the last wait() or drain().
  [[nodiscard]] int descriptor() const { return bell_.descriptor(); }
  void drain();
  /// Returns the final value of `holds()`, which is called after every event.
  [[nodiscard]] bool wait(MonotonicTime until, const std::function<bool()>& holds);
  /// Waits for discovery: for the spin time, counted from now, and a moment longer while a discovered participant has
  /// not announced its endpoints. Returns the final value of `holds()`.
  [[nodiscard]] bool find(const std::function<bool()>& holds);
  /// The same for complete lists, counted from the join: what is unknown afterwards counts as absent. Returns early
  /// when `holds` returns true.
  void find_all(const std::function<bool()>& holds = [] { return false; });

  /// Uses nothing else of this class.
  template <typename F>
  [[nodiscard]] auto look(F see) const {
    std::optional<decltype(see(std::declval<const transport_dds::RemoteGraph&>()))> seen;
    network_->look([&](const auto& graph) { seen = see(graph); });
    return std::move(*seen);
  }

  /// Returns the specification of an endpoint of this node.
  [[nodiscard]] EndpointSpec spec_of(std::string topic, const msgs::MessageType& type, const QoS& qos) const;
  [[nodiscard]] Transport& transport() { return broker_; }
  /// Returns why an endpoint made here is not on the network, if known. `where`: a topic, or "service " and a name.
  [[nodiscard]] std::optional<Problem> problem_of(const std::string& where) const;
  /// A type whose messages are bytes. Valid as long as this object.
  [[nodiscard]] const msgs::MessageType& bytes_of(const std::string& type, const std::string& hash);

  /// As runtime::Container::call_service(), for remote servers. Waits for the server at most for the spin time, and a
  /// moment longer for a discovered one.
  /// Errors: no server offers it, or not with that type, or with another middleware's protocol.
  [[nodiscard]] Result<std::unique_ptr<runtime::ServiceCall>, Problem> start_call(const std::string& service,
                                                                                  const msgs::ServiceType& type,
                                                                                  void* request,
                                                                                  std::function<void()> on_answer);
  /// The response, as JSON. Errors: of start_call(); no answer within the limit.
  [[nodiscard]] Result<nlohmann::json, Problem> call(const std::string& service, const char* type,
                                                     const nlohmann::json& request, Duration limit);
  /// Its client is made, so that several of them find their servers at the same time. Errors: no such type here.
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
  std::map<std::pair<std::string, std::string>, std::unique_ptr<ByteMessageType>> byte_types_;
  Guarded<std::vector<Problem>> problems_;  // why an end is not there, or a service cannot be called
  runtime::Broker broker_{clock_};
  ServiceClients clients_;
  std::unique_ptr<networking::Network> network_;  // the last: its threads use what is above
};

}  // namespace nacelle::remote
