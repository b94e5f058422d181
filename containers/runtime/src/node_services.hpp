// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/node/parameter.hpp"
#include "nacelle/runtime/container.hpp"
#include "node_runtime.hpp"
#include "rosout.hpp"
#include "transition_lanes.hpp"

namespace nacelle::runtime {

class NodeFace;
struct Record;

/// What ROS 2's tools expect of every node, offered in the names of a container's components while they are loaded: the services
/// of parameters, lifecycle and types, /parameter_events and /rosout. Ordinary services and topics, for components too.
///
/// They answer on one thread of their own. What is asked for is read beside the component's callbacks and answered at once; what
/// is to be set is handed to the component's executor, and a transition to a thread that lives as long as it; those are answered
/// when they are done. So nothing that one node is busy with holds up a question to any.
/// The container's own node has the services of parameters, too: `ros2 param list` waits for those of every node that it finds.
/// Threads: any.
/// Source: rclcpp (jazzy), parameter_service.cpp, node_parameters.cpp; rclcpp_lifecycle, lifecycle_node_interface_impl.cpp.
class NodeServices {
 public:
  static constexpr std::uint64_t kOwnNode = 0;  // components are counted from 1
  /// `own_node`, the container's, publishes the log of what is no node's. `which` is not None.
  NodeServices(Container& container, Commons& commons, NodeInterfaces which, const std::string& own_node);
  /// Waits for transitions that are under way. No component's face is left.
  ~NodeServices();
  NodeServices(const NodeServices&) = delete;
  NodeServices& operator=(const NodeServices&) = delete;

  /// A node is being made: what its constructor logs is its own. To be taken back with forget_log() if it does not come to be.
  void keep_log(const std::string& node) { rosout_.add(node); }
  void forget_log(const std::string& node) { rosout_.remove(node); }
  /// A component is made, has its id, and none of its callbacks runs yet.
  void begin(Record& record);
  /// None of its callbacks runs any more (`returned`), or one does not return.
  void end(Record& record, bool returned);
  /// The services of a node; null if there are to be none.
  [[nodiscard]] std::shared_ptr<NodeFace> offer(std::uint64_t id, const std::string& node, bool managed);
  /// They go at once; whoever waits for an answer is told that there will be none.
  void withdraw(std::uint64_t id, const std::shared_ptr<NodeFace>& face);
  static void report_services(const NodeFace* face, std::vector<ServiceReport>& out);
  void report_own_services(std::vector<ServiceReport>& out) const { report_services(own_face_.get(), out); }

  // What the services ask; the id of the container's own node is kOwnNode.
  [[nodiscard]] Result<std::vector<ParameterReport>, Problem> parameters(std::uint64_t id) const;
  using Then = std::function<void(Result<std::vector<SetParametersResult>, Problem>)>;
  /// Sets parameters between two callbacks of the component, each on its own or, `atomically`, all or none with one result; refuses
  /// in rclcpp's words. Calls `then` once: on the component's executor, or at once with the reason why not. Does nothing if `asker`
  /// or the component has gone by then. A value that is not set undeclares a parameter of dynamic type.
  void set_parameters(std::uint64_t id, std::vector<Parameter> parameters, bool atomically, std::weak_ptr<void> asker,
                      const Then& then);
  /// Unknown: there is no such component, or it has no lifecycle.
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
  TransitionLanes lanes_;          // its jobs use what is above
  ParameterStore own_parameters_;  // changed on the services' thread
  std::shared_ptr<NodeFace> own_face_;
};

}  // namespace nacelle::runtime
