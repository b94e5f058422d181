// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/control/client.hpp"

namespace nacelle::ask {

/// Limit for what a node knows at once.
inline constexpr Duration kAnswerLimit = 3s;
/// Limit for a transition, a load or an unload: a component may take its time to find its device, and the container gives it up
/// after half a minute.
inline constexpr Duration kTransitionLimit = 80s;

/// The nodes at the other end of a connection: those of a container on this machine, or those of ROS 2's network. Every verb asks
/// them through this class, so it is defined once.
///
/// Threads: one at a time.
class Nodes {
 public:
  /// `client` outlives this object.
  explicit Nodes(control::Client& client) : client_(client) {}

  /// Returns the full name of a node: "/lidar" of "lidar", of "/lidar", or of the id of a container's component. Errors: no node of
  /// that name, with the nearest one; several nodes of that name in different namespaces.
  [[nodiscard]] Result<std::string, Problem> find(const std::string& name);
  /// Calls a service and returns the response; messages are JSON as interfaces/msgs/README.md describes it.
  /// Errors: no such service, no answer within the limit, a request that does not fit the type.
  [[nodiscard]] Result<nlohmann::json, Problem> call(const std::string& service, const char* type,
                                                     const nlohmann::json& request, Duration limit = kAnswerLimit);

 private:
  control::Client& client_;
};

}  // namespace nacelle::ask
