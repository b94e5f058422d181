// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <rcl_interfaces/srv/describe_parameters.hpp>
#include <rcl_interfaces/srv/get_parameter_types.hpp>
#include <rcl_interfaces/srv/get_parameters.hpp>
#include <rcl_interfaces/srv/list_parameters.hpp>
#include <rcl_interfaces/srv/set_parameters.hpp>
#include <rcl_interfaces/srv/set_parameters_atomically.hpp>
#include <string>
#include <vector>

#include "nacelle/node/service.hpp"
#include "nacelle/runtime/introspection.hpp"
#include "node_runtime.hpp"

namespace nacelle::runtime {

class NodeServices;

/// rclcpp's six services of a node's parameters. As in rclcpp, an unknown name leaves an answer without values, and
/// only setting is refused with a reason. An integer for a double is converted, as in a launch file; rclcpp refuses it.
class ParameterServices {
 public:
  ParameterServices(NodeServices& desk, std::uint64_t id) : desk_(desk), id_(id) {}
  /// `self` keeps everything alive while an answer is pending.
  void start(NodeRuntime& node, const std::shared_ptr<ParameterServices>& self);

 private:
  [[nodiscard]] std::vector<ParameterReport> read() const;
  void set(const RequestId& id, const rcl_interfaces::srv::SetParameters::Request& request);
  void set(const RequestId& id, const rcl_interfaces::srv::SetParametersAtomically::Request& request);

  NodeServices& desk_;
  const std::uint64_t id_;
  std::weak_ptr<ParameterServices> self_;
  Service<rcl_interfaces::srv::DescribeParameters>::SharedPtr describe_;
  Service<rcl_interfaces::srv::GetParameterTypes>::SharedPtr types_;
  Service<rcl_interfaces::srv::GetParameters>::SharedPtr get_;
  Service<rcl_interfaces::srv::ListParameters>::SharedPtr list_;
  Service<rcl_interfaces::srv::SetParameters>::SharedPtr set_;
  Service<rcl_interfaces::srv::SetParametersAtomically>::SharedPtr set_atomically_;
};

/// Returns the answer of list_parameters. Pure.
[[nodiscard]] rcl_interfaces::msg::ListParametersResult listed(
    const std::vector<std::string>& names, const rcl_interfaces::srv::ListParameters::Request& wish);

}  // namespace nacelle::runtime
