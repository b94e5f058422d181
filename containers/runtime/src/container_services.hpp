// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/guarded.hpp"
#include "node_runtime.hpp"
#include "transition_lanes.hpp"

namespace nacelle::runtime {

class CompositionHost;
class Container;

/// The container's own node, with services below <node>/_container: rclcpp's component_container's (load_node,
/// unload_node and list_nodes of composition_interfaces), and those of nacelle_interfaces. Every component can call
/// them with a Client; a transport may offer them on the network.
///
/// They answer on their own thread, one call after the other: a component that loads slowly delays only that thread. A
/// component that waits for an answer of these services during its own load would wait for itself, until the load times
/// out. Transitions have their own threads. Services of offer() answer on the executor `quick`. Differences from
/// rclcpp: package_name and log_level are ignored (class names are unique, and there is one log level), and of
/// extra_arguments only the types of rclcpp's own two are checked, because all components are in one process anyway.
class ContainerServices {
 public:
  /// Returns the full name of the node; invalid characters of `name` become '_'.
  [[nodiscard]] static std::string node_of(const std::string& name, const std::string& name_space);
  /// `name` is the node's. `quick` must outlive this; null: the thread of the other services is used instead.
  ContainerServices(Container& container, Commons& commons, const std::string& name, const std::string& name_space,
                    Executor* quick);
  /// Waits for the running call.
  ~ContainerServices();
  ContainerServices(const ContainerServices&) = delete;
  ContainerServices& operator=(const ContainerServices&) = delete;

  /// Container::compose_through()
  void compose_through(CompositionHost* host) { *host_.lock() = host; }
  [[nodiscard]] std::string node() const { return node_.identity().fully_qualified(); }
  /// Container::offer_service()
  [[nodiscard]] std::unique_ptr<ServiceHandle> offer(const std::string& name, const msgs::MessageType& request,
                                                     const msgs::MessageType& response, ServiceCallback callback);
  void report_services(std::vector<ServiceReport>& out) const {
    node_.report_services(out);
    quick_node_.report_services(out);
  }

 private:
  template <typename S>
  static bool run(void* services, std::int64_t call, const void* request, void* response);
  static bool run_transition(void* services, std::int64_t call, const void* request, void* response);

  Container& container_;
  Guarded<CompositionHost*> host_{std::in_place, nullptr};  // locked while it carries out a call
  Executor executor_;
  NodeRuntime node_, quick_node_;  // one node; the second has the services of offer()
  std::vector<std::unique_ptr<ServiceHandle>> services_;
  std::unique_ptr<ServiceHandle> change_state_;
  TransitionLanes lanes_;  // its jobs use what is above
};

}  // namespace nacelle::runtime
