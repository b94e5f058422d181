// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "control/client.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::ask {

/// The nodes at the other end of a connection: those of a container on this machine, or those of ROS 2's network. Every
/// verb calls nodes through this class, so each verb has one implementation for both.
///
/// Threads: one at a time.
class Nodes {
 public:
  /// The time limit of a node's answer, and the additional time for its delivery by a busy container.
  static constexpr Duration kAnswerLimit = 3s, kOnTheWay = 7s;

  /// `client` must outlive this object.
  explicit Nodes(control::Client& client, Duration limit = kAnswerLimit, Duration on_the_way = kOnTheWay)
      : client_(client), limit_(limit), on_the_way_(on_the_way) {}

  /// Returns the full name of a node. `name`: "/lidar", "lidar", or the id of a container's component.
  /// Errors: no such node, with the nearest name; several nodes of that name in different namespaces.
  [[nodiscard]] Result<std::string, Problem> find(const std::string& name);
  /// A node, and the container that holds it.
  struct Found {
    std::string node;
    std::string container;  ///< The container's node; empty: not a Nacelle container, or unknown.
  };
  /// Returns the full name of a node as find() does, and its container. On the network, if no Nacelle container holds
  /// the node, this takes the full discovery time.
  [[nodiscard]] Result<Found, Problem> locate(const std::string& name);
  struct FoundContainer {
    std::string node;
    bool is_nacelle = false;  ///< Offers the services of nacelle_interfaces beside those of composition_interfaces.
  };
  /// Returns the container of that name; for an empty name the only one, or the one at the other end.
  /// Errors: no such container; several containers and an empty name.
  [[nodiscard]] Result<FoundContainer, Problem> container(const std::string& name);
  /// Returns the graph as seen by the other end (answers/graph_verbs.hpp).
  [[nodiscard]] Result<nlohmann::json, Problem> graph();
  /// Calls a service and returns the response; messages are JSON as interfaces/msgs/README.md describes it.
  /// Errors: no such service, no answer within the limit, a request that does not match the type.
  [[nodiscard]] Result<nlohmann::json, Problem> call(const std::string& service, const char* type,
                                                     const nlohmann::json& request);
  [[nodiscard]] Result<nlohmann::json, Problem> call(const std::string& service, const char* type,
                                                     const nlohmann::json& request, Duration limit);
  /// Finds a container as container() does and calls one of its services of nacelle_interfaces. `service` is the name
  /// below ~/_container.
  /// Errors: as container() and call(); the container is not Nacelle's.
  [[nodiscard]] Result<nlohmann::json, Problem> ask_container(const std::string& name, const char* service,
                                                              const char* type,
                                                              const nlohmann::json& request = nlohmann::json::object());
  /// Announces services that will be called next, each with its type, and returns which of them are offered. On the
  /// network their clients discover the servers meanwhile. If the other end does not answer, all are false and the
  /// following calls report the reason.
  std::vector<bool> prepare(const std::vector<std::pair<std::string, const char*>>& services);

 private:
  control::Client& client_;
  const Duration limit_, on_the_way_;
};

/// Returns the full name of a service of a container's node: "/robot/_container/get_faults".
[[nodiscard]] std::string service_of_container(const std::string& container, const char* name);
/// Returns the Problem in a response of nacelle_interfaces.
[[nodiscard]] Problem problem_of(const nlohmann::json& response);
/// Replaces a list of at most one element by the element; removes an empty one.
void unwrap(nlohmann::json& message, const char* key);

}  // namespace nacelle::ask
