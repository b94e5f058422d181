// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "nacelle/host/node_host.hpp"
#include "nacelle/host/service_graph.hpp"

namespace nacelle {

/// Services whose names and types are known at run time only, as a viewer needs them: `GenericServices services{host()}`.
///
/// The host outlives this object and what it makes.
class GenericServices {
 public:
  explicit GenericServices(NodeHost& host) : host_(host) {}

  /// Tells the listener of all servers and clients of the container and of each change, until the handle goes. Threads: any.
  [[nodiscard]] std::unique_ptr<ServiceWatchHandle> watch(ServiceListener& listener) {
    return host_.watch_services(listener);
  }
  /// Returns a client of a service with a full name. `callback` runs on the node's executor. Threads: the component's executor.
  [[nodiscard]] std::unique_ptr<ClientHandle> client(const std::string& name, const msgs::MessageType& request,
                                                     const msgs::MessageType& response, ResponseCallback callback) {
    return host_.create_client(name, request, response, callback, nullptr);
  }

 private:
  NodeHost& host_;
};

}  // namespace nacelle
