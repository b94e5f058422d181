// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/host/transport.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::session {

/// Publishes faults and states for ROS 2's tools: /diagnostics (diagnostic_msgs/DiagnosticArray) and each managed
/// node's ~/transition_event (lifecycle_msgs/TransitionEvent). Threads: one.
class FaultTopics {
 public:
  explicit FaultTopics(runtime::Container& container);
  ~FaultTopics();

  /// Creates missing topics of managed nodes, and removes those of unloaded nodes.
  void follow(const std::vector<runtime::ComponentInfo>& components);
  void publish(const runtime::StateChange& change);
  /// A component that was left out, and the reason.
  struct Absent {
    std::string node, plugin, why;
  };
  /// Publishes an error for each component that is faulted, has an open fault or is absent, and OK once for a component
  /// that has recovered. Returns whether there was an error.
  bool publish_diagnostics(const std::vector<runtime::ComponentInfo>& components, const std::vector<Absent>& absent);

 private:
  runtime::Container& container_;
  std::unique_ptr<Writer> diagnostics_;
  std::map<std::string, std::unique_ptr<Writer>> events_;
  std::vector<std::string> were_faulted_;
};

/// Number and label of lifecycle_msgs for the step between two states, as in rcl_lifecycle. Pure.
struct TransitionName {
  std::uint8_t id = 0;
  const char* label = "";
};
[[nodiscard]] TransitionName name_of_step(StateId from, StateId to);

}  // namespace nacelle::session
