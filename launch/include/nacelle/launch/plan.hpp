// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nacelle/base/names.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/launch/namespace_plan.hpp"
#include "nacelle/launch/network_plan.hpp"
#include "nacelle/launch/parameter_file.hpp"
#include "nacelle/policies/fault_handling.hpp"
#include "nacelle/policies/thread_policy.hpp"
#include "nacelle/qos/profiles.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle::launch {

// What to start, with every substitution done: the values that the container acts on. Nothing here does anything.

enum class Side : std::uint8_t { Publisher, Subscription };

/// What the launch file says about one side of one topic of a component.
struct TopicQos {
  std::string topic;  ///< Fully qualified, after remapping.
  Side side = Side::Publisher;
  QosPatch patch;
  std::optional<QoS> start;  ///< The values of patch.profile.
  Place where;

  /// The QoS that results from the one in the component's code.
  [[nodiscard]] QoS applied_to(const QoS& in_code) const { return patch.applied_to(start.value_or(in_code)); }
};

/// What a component waits for before it is activated.
enum class When : std::uint8_t {
  Active,        ///< The other node is active.
  FirstMessage,  ///< A topic (detail) of the other node has had a message.
  Tf,            ///< A transform (detail "a->b") can be looked up.
  Service        ///< A service (detail) can be called.
};
struct AfterCondition {
  std::string node;  ///< Fully qualified name of a component of this plan.
  When when = When::Active;
  std::string detail;
  std::optional<Duration> timeout;  ///< None: the lifecycle manager's own.
  Place where;
};

enum class Isolation : std::uint8_t { None, Process };

/// Limits of a stream; a breach is reported.
struct Budget {
  std::string topic;  ///< Fully qualified; empty: every stream of the component.
  std::optional<std::uint64_t> max_copies;
  std::optional<Duration> max_age;
  std::optional<double> min_hz;
  Place where;
};

/// The state that the bring-up takes a component to.
enum class TargetState : std::uint8_t { Unconfigured, Inactive, Active };

/// A component to load.
struct ComponentPlan {
  Place where;
  std::string package;
  std::string plugin;                 ///< "nacelle::lidar::LidarComponent"
  std::string name;                   ///< The node's name.
  std::string namespace_;             ///< Absolute.
  std::vector<Parameter> parameters;  ///< Each name once, with the value that won.
  std::vector<RemapRule> remaps;      ///< In the order in which they are tried.
  std::vector<Place> remap_lines;     ///< Of each remap.
  std::size_t shared_remaps = 0;      ///< So many of them, at the front, are set_remap's and need not fit every node.
  std::vector<Parameter> extra_arguments;
  std::vector<TopicQos> qos;
  std::vector<AfterCondition> after;
  ThreadPolicy thread;
  bool required = true;  ///< False: the bring-up goes on without it.
  Isolation isolate = Isolation::None;
  std::vector<Budget> budgets;
  FaultHandling on_fault;
  TargetState target = TargetState::Active;
  /// After a crash: an actuator that was active comes back active, and not inactive.
  bool resume_active = false;

  [[nodiscard]] std::string full_name() const { return fully_qualified_node_name(namespace_, name); }
  /// `in_code`, changed by what the file says about that side of the topic (its full name after remapping).
  [[nodiscard]] QoS qos_for(const std::string& topic, Side side, const QoS& in_code) const;
};

/// A program in a process of its own, started before and stopped after the components.
struct ProgramPlan {
  Place where;
  std::string label;       ///< For logs: exec_name, name or the program's file name.
  std::string package;     ///< Of a `node`: with `executable` the program to look for. Empty for an `executable`.
  std::string executable;  ///< Of a `node`; of an `executable` the first word of its command.
  std::string name;        ///< As a node; empty: the program's own.
  std::string namespace_;  ///< Absolute; empty: the program's own.
  std::vector<std::string> arguments;
  std::vector<std::string> ros_arguments;  ///< What follows --ros-args: names, remaps, parameters and their files.
  std::vector<std::pair<std::string, std::optional<std::string>>> environment;  ///< Set to, or unset.
  std::string working_directory;                                                ///< Empty: the container's.
  std::string output;  ///< screen, log, both, own_log or full; empty: the default.
  bool respawn = false;
  std::optional<Duration> respawn_delay;
  std::optional<Duration> sigterm_timeout;
  std::optional<Duration> sigkill_timeout;
  bool required = false;  ///< Nacelle's: true ends the launch when the program ends.

  /// What follows the program's name: `arguments`, then --ros-args and what belongs to it, if there is any.
  [[nodiscard]] std::vector<std::string> command_arguments() const;
};

/// The process that holds the components.
struct ContainerPlan {
  std::string name = "nacelle";
  std::string namespace_ = "/";
  std::vector<Parameter> parameters;
  Place where;
  bool declared = false;  ///< False: the files name no node_container.
};

/// An argument that the files declare.
struct ArgumentPlan {
  std::string name;
  std::optional<std::string> default_value;
  std::string description;
  std::vector<std::string> choices;
  Place where;
};

/// Text that the files want shown.
struct MessagePlan {
  std::string text;
  Place where;
};

/// A set_remap, for all nodes below it.
struct SharedRemap {
  RemapRule rule;
  Place where;
};

/// A section of a parameter file that matches no node.
struct UnusedSection {
  std::string pattern;
  Place where;
};

/// Everything that one launch file asks for.
struct Plan {
  std::string file;
  ContainerPlan container;
  NamespacePlan name_space;
  NetworkPlan network;
  std::vector<ComponentPlan> components;  ///< In the files' order.
  std::vector<ProgramPlan> programs;
  std::vector<ArgumentPlan> arguments;  ///< Of all files, each name once.
  std::vector<MessagePlan> messages;
  std::vector<UnusedSection> unused_sections;
  std::vector<SharedRemap> shared_remaps;

  [[nodiscard]] const ComponentPlan* find(std::string_view full_name) const;
};

/// The whole plan as text, one value per line: two plans are the same if their texts are. Locations are left out.
[[nodiscard]] std::string to_text(const Plan& plan);

[[nodiscard]] const char* to_text(When when);
[[nodiscard]] const char* to_text(Side side);
[[nodiscard]] const char* to_text(TargetState state);

}  // namespace nacelle::launch
