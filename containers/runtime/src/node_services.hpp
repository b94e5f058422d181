// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/node/parameter.hpp"
#include "nacelle/runtime/container.hpp"
#include "node_face.hpp"
#include "node_runtime.hpp"
#include "rosout.hpp"
#include "transition_lanes.hpp"

namespace nacelle::runtime {

struct NodeRecord;

/// Provides what ROS 2's tools expect of every node, on behalf of a container's loaded components: the services of
/// parameters, lifecycle and types, /parameter_events and /rosout. They are ordinary services and topics that
/// components can use too.
///
/// The services answer on one thread of their own. Reads happen beside the component's callbacks and are answered at
/// once. Parameters are set on the component's executor, and a transition runs on its own thread; both are answered
/// when they are done. So a busy node does not delay requests to any node. The container's own node has the parameter
/// services, too: `ros2 param list` waits for those of every node that it discovers.
/// Threads: any.
/// Source: rclcpp (jazzy), parameter_service.cpp, node_parameters.cpp; rclcpp_lifecycle,
/// lifecycle_node_interface_impl.cpp.
class NodeServices {
 public:
  static constexpr std::uint64_t kOwnNode = 0;  // components are counted from 1
  /// `own_node`, the container's, publishes log lines that belong to no node. `which` is not None.
  NodeServices(Container& container, Commons& commons, NodeInterfaces which, const std::string& own_node);
  /// Waits for running transitions. Precondition: no NodeFace is left.
  ~NodeServices();
  NodeServices(const NodeServices&) = delete;
  NodeServices& operator=(const NodeServices&) = delete;

  /// Call before a node's constructor: its log lines become the node's. If the node is not made, undo this with
  /// forget_log().
  void keep_log(const std::string& node) { rosout_.add(node); }
  void forget_log(const std::string& node) { rosout_.remove(node); }
  /// Call once a node is constructed and has its id, before any of its callbacks runs. `has_lifecycle`: it is a
  /// component with one.
  void begin(NodeRecord& node, bool has_lifecycle);
  /// Call when none of its callbacks runs any more (`returned`), or when one does not return.
  void end(NodeRecord& node, bool returned);
  /// Offers these services in the name of a node. Returns null if they are disabled.
  [[nodiscard]] std::shared_ptr<NodeFace> offer(std::uint64_t id, const std::string& node, NodeFace::Parts parts);
  /// Withdraws them at once; waiting callers get a notice that there will be no answer.
  void withdraw(std::uint64_t id, const std::shared_ptr<NodeFace>& face);
  static void report_services(const NodeFace* face, std::vector<ServiceReport>& out);
  void report_own_services(std::vector<ServiceReport>& out) const { report_services(own_face_.get(), out); }

  // Used by the services; the id of the container's own node is kOwnNode.
  [[nodiscard]] Result<std::vector<ParameterReport>, Problem> parameters(std::uint64_t id) const;
  using Then = std::function<void(Result<std::vector<SetParametersResult>, Problem>)>;
  /// Sets parameters between two callbacks of the component, each on its own or, `atomically`, all or none with one
  /// result; refuses with rclcpp's texts. Calls `then` once: on the component's executor, or at once with the reason
  /// for a refusal. Does nothing if `asker` or the component is gone by then. A value that is not set undeclares a
  /// parameter of dynamic type.
  void set_parameters(std::uint64_t id, std::vector<Parameter> parameters, bool atomically, std::weak_ptr<void> asker,
                      const Then& then);
  /// Returns Unknown if there is no such component, or it has no lifecycle.
  [[nodiscard]] StateId state(std::uint64_t id) const;
  [[nodiscard]] TransitionOutcome trigger(std::uint64_t id, Transition transition) const;
  [[nodiscard]] TransitionLanes& lanes() { return lanes_; }
  /// Runs the services.
  [[nodiscard]] Executor& executor() { return executor_; }

 private:
  Container& container_;
  Commons& commons_;
  const NodeInterfaces which_;
  Executor executor_;
  NodeGroups log_node_;
  CallbackGroup log_group_;
  Rosout rosout_;
  TransitionLanes lanes_;          // its jobs use the members above
  ParameterStore own_parameters_;  // changed on the services' thread
  std::shared_ptr<NodeFace> own_face_;
};

}  // namespace nacelle::runtime
