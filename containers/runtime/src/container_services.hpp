// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "node_runtime.hpp"

namespace nacelle::runtime {

class Container;

/// The container's own node, with the services of rclcpp's component_container: <node>/_container/load_node, unload_node and
/// list_nodes of composition_interfaces. Every component reaches them with a Client; a transport may carry them outside.
///
/// They answer on a thread of their own, one call after the other: whoever is loaded keeps that thread waiting and no other.
/// Where rclcpp's meaning and ours differ: package_name and log_level are not looked at (class names are unique, and there is one
/// log level), and of extra_arguments only the types of rclcpp's own two are checked: all components are in one process anyway.
/// Source: rclcpp_components (jazzy), component_manager.cpp.
class ContainerServices {
 public:
  /// `name` is the node's; characters that a node's name cannot have become '_'.
  ContainerServices(Container& container, Commons& commons, const std::string& name, const std::string& name_space);
  /// Waits for the call that is being answered.
  ~ContainerServices();
  ContainerServices(const ContainerServices&) = delete;
  ContainerServices& operator=(const ContainerServices&) = delete;

  [[nodiscard]] std::string node() const { return node_.identity().fully_qualified(); }
  void report_services(std::vector<ServiceReport>& out) const { node_.report_services(out); }

 private:
  template <typename S>
  static bool run(void* container, std::int64_t call, const void* request, void* response);

  Executor executor_;
  NodeRuntime node_;
  std::unique_ptr<ServiceHandle> load_, unload_, list_;
};

}  // namespace nacelle::runtime
