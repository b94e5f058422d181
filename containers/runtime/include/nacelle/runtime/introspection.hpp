// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/node/parameter.hpp"

// Information for tools about a container's nodes, streams, services and parameters (Container::endpoints() and
// similar).
namespace nacelle::runtime {

/// One end of a stream.
struct EndpointReport {
  std::string topic, type, type_hash;
  std::string node;  ///< "/lidar"
  bool is_writer = false;
  bool in_other_process = false;
  std::uint64_t id = 0;  ///< Unique on the host while its process lives.
  QoS qos{1};            ///< In force, as resolved().
  CommandTimeout command_timeout;
};

/// A service that a node offers, or one that it calls.
struct ServiceReport {
  std::string name, type;  ///< "/ekf/reset", "std_srvs/srv/Empty"
  std::string node;
  bool is_server = true;
  bool open = true;          ///< True while a server's lifecycle gate is open, so it answers.
  bool is_standard = false;  ///< The container offers it on behalf of each node (ContainerOptions::node_interfaces).
};

/// A declared parameter.
struct ParameterReport {
  std::string name;
  ParameterValue value;
  ParameterType type = ParameterType::NotSet;  ///< As declared; the value may not be set yet.
  ParameterDescriptor descriptor;
};

/// A call of a service by a tool. Threads: the owner's only. Destroying the object ends the call and discards its
/// answer.
class ServiceCall {
 public:
  enum class State : std::uint8_t {
    Waiting,
    Answered,
    Refused,  ///< There will be no answer: the server was destroyed, or its callback failed.
  };
  virtual ~ServiceCall() = default;
  [[nodiscard]] virtual State state() const = 0;
  /// Null unless it is answered; valid as long as the call.
  [[nodiscard]] virtual const void* response() const = 0;
};

}  // namespace nacelle::runtime
