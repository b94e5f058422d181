// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/names.hpp"
#include "nacelle/node/parameter.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle {

class Context;

/// QoS values that the launch file gives to one side of a topic; what is not set keeps the code's value.
struct QosOverride {
  std::string topic;  ///< As written; expanded with the node's name before it is compared.
  bool for_publisher = true;
  std::function<QoS(const QoS&)> apply;  ///< From the code's value to the one in force.
};

/// What a composition gives to a node when it makes it. Same words as rclcpp's.
class NodeOptions {
 public:
  explicit NodeOptions(Context& context) : context_(&context) {}

  /// Name and namespace of the composition; empty keeps the component's own name, "/" is the root.
  NodeOptions& node_name(std::string name) {
    name_ = std::move(name);
    return *this;
  }
  NodeOptions& node_namespace(std::string name_space) {
    namespace_ = std::move(name_space);
    return *this;
  }
  NodeOptions& parameter_overrides(std::map<std::string, ParameterValue> overrides) {
    overrides_ = std::move(overrides);
    return *this;
  }
  NodeOptions& append_parameter_override(const std::string& name, ParameterValue value) {
    overrides_[name] = std::move(value);
    return *this;
  }
  /// Where refused values go, instead of an exception from the constructor; null for the exception.
  NodeOptions& collect_parameter_faults(std::shared_ptr<ParameterFaults> faults) {
    faults_ = std::move(faults);
    return *this;
  }
  NodeOptions& remap_rules(std::vector<RemapRule> rules) {
    remaps_ = std::move(rules);
    return *this;
  }
  NodeOptions& qos_overrides(std::vector<QosOverride> overrides) {
    qos_ = std::move(overrides);
    return *this;
  }

  /// Returns the options of another node of the same component: one that it makes beside itself, in its constructor or in a
  /// callback, and destroys itself. They keep the namespace, remap rules, QoS and use_sim_time of the launch file. The other
  /// node has the name and the parameters that the code gives it.
  ///
  ///     Mapper(const NodeOptions& options) : LifecycleNode("mapper", options), client_("mapper_client", options.another_node()) {}
  [[nodiscard]] NodeOptions another_node() const {
    NodeOptions other{*this};
    other.name_.clear();
    std::erase_if(other.overrides_, [](const auto& entry) { return entry.first != "use_sim_time"; });
    for (RemapRule& rule : other.remaps_) {
      if (rule.kind == RemapKind::NodeName && rule.node.empty())
        rule.node = "/";  // the component is renamed, no other node
    }
    return other;
  }

  [[nodiscard]] Context& context() const { return *context_; }
  [[nodiscard]] const std::string& node_name() const { return name_; }
  [[nodiscard]] const std::string& node_namespace() const { return namespace_; }
  [[nodiscard]] const std::map<std::string, ParameterValue>& parameter_overrides() const { return overrides_; }
  [[nodiscard]] const std::shared_ptr<ParameterFaults>& parameter_faults() const { return faults_; }
  [[nodiscard]] const std::vector<RemapRule>& remap_rules() const { return remaps_; }
  [[nodiscard]] const std::vector<QosOverride>& qos_overrides() const { return qos_; }

 private:
  Context* context_;
  std::string name_, namespace_;
  std::map<std::string, ParameterValue> overrides_;
  std::shared_ptr<ParameterFaults> faults_;
  std::vector<RemapRule> remaps_;
  std::vector<QosOverride> qos_;
};

}  // namespace nacelle
