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

/// The container's own node, with services below <node>/_container: rclcpp's component_container's (load_node, unload_node and
/// list_nodes of composition_interfaces), and those of nacelle_interfaces. Every component reaches them with a Client; a transport may
/// carry them outside.
///
/// They answer on a thread of their own, one call after the other: a component that takes its time to load keeps that thread waiting and
/// no other. So a component that waits for an answer of these services while it is loaded waits for itself, until it is given up.
/// Transitions have threads of their own. Services of offer() answer on the executor `quick`.
/// Where rclcpp's meaning and ours differ: package_name and log_level are not looked at (class names are unique, and there is one
/// log level), and of extra_arguments only the types of rclcpp's own two are checked: all components are in one process anyway.
class ContainerServices {
 public:
  /// The full name of the node; characters of `name` that it cannot have become '_'.
  [[nodiscard]] static std::string node_of(const std::string& name, const std::string& name_space);
  /// `name` is the node's. `quick` outlives this; null: the thread of the other services takes its place.
  ContainerServices(Container& container, Commons& commons, const std::string& name, const std::string& name_space,
                    Executor* quick);
  /// Waits for the call that is being answered.
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
  NodeRuntime node_, quick_node_;  // one node; the second has what others offer
  std::vector<std::unique_ptr<ServiceHandle>> services_;
  std::unique_ptr<ServiceHandle> change_state_;
  TransitionLanes lanes_;  // its jobs use what is above
};

}  // namespace nacelle::runtime
