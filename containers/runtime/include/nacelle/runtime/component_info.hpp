// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "nacelle/policies/fault_handling.hpp"
#include "nacelle/policies/thread_policy.hpp"

namespace nacelle::runtime {

/// A transform that a node broadcasts, or broadcasts only while no other node does (FrameClaimKind).
struct ClaimedFrame {
  std::string node, parent, child;
  FrameClaimKind kind = FrameClaimKind::Primary;
  Place origin;       ///< What to change so that the node does not broadcast it: the parameter publish_tf.
  bool owns = false;  ///< Set by frames() only: of all nodes that claim the child, this one broadcasts it.
};

/// What a component's constructor declared, without its endpoints and transforms.
struct Declarations {
  struct Value {
    std::string name;
    ParameterValue value;
    bool given = false;                          ///< The composition set the value; else it is the default.
    ParameterType type = ParameterType::NotSet;  ///< As declared; the value may not be set.
    ParameterDescriptor descriptor{};
  };
  std::vector<Value> parameters;
  std::vector<std::string> unknown_parameters;  ///< Given, but not declared by the component.
  std::vector<FrameUse> frame_uses;
  std::vector<DeviceUse> device_uses;
  std::vector<std::string> services;  ///< Full names of the services that it offers.
  std::vector<bool> used_remaps;      ///< Indexed like LoadRequest::remaps: whether the rule changed a name.
  std::string package;                ///< The package that registers the class.
};

/// A component to create from a plugin.
struct LoadRequest {
  std::string plugin;            ///< "nacelle::lidar::LidarComponent"
  std::string name, name_space;  ///< Empty: the component's own name, "/".
  std::map<std::string, ParameterValue> parameters;
  std::vector<RemapRule> remaps;
  std::vector<QosOverride> qos;
  ThreadPolicy thread;
  FaultHandling on_fault{};
  /// Refused values are collected here, and the component is made with the defaults instead. Null: the first fails the
  /// load.
  std::shared_ptr<ParameterFaults> faults{};
};

struct ComponentInfo {
  std::uint64_t id = 0;  ///< Starts at 1, never reused.
  std::string node;      ///< "/lidar"
  std::string plugin, library;
  StateId state = StateId::Unknown;  ///< Unknown for a plain Node.
  bool managed = true;               ///< A LifecycleNode.
  FaultReason fault;                 ///< Why it is faulted; empty code when it is not.
  /// Of load()'s answer only: parameters that were given and that the component does not have.
  std::vector<std::string> warnings{};
  bool actuator = false;                           ///< True if it has registered a stop frame, so it moves something.
  std::shared_ptr<const Declarations> declared{};  ///< Of load()'s answer only.
  std::vector<std::string> other_nodes{};          ///< Full names of the nodes that it has made beside itself.
  bool isolated = false;                           ///< It has a process of its own.
  std::int32_t process = 0;                        ///< The number of that process; 0: there is none, or it has ended.
  std::vector<FaultReason>
      open_faults{};  ///< Faults that it repairs itself; its state does not change, and `fault` is empty.
};

/// A component became faulted, or had an open fault.
struct FaultEvent {
  std::uint64_t number = 0;  ///< Of the container, from 1.
  std::string node, code, text;
  std::string callback;  ///< Where it happened: "subscription /scan", "transition on_configure", "thread lidar_rx".
  WallTime when;
  bool is_open_fault = false;        ///< LifecycleNode::open_fault(): the component stays as it is.
  std::optional<Duration> lasted{};  ///< Of an open fault that is over.
};

/// A node entered a state; a transition makes two or three of these.
struct StateChange {
  std::string node;
  StateId from = StateId::Unknown, to = StateId::Unknown;
  WallTime when;
};

/// The result of unloading a component.
struct UnloadOutcome {
  bool image_closed = false;  ///< True if the library is unmapped.
  std::string held_by;        ///< Otherwise the reason: "2 messages of /camera/image_raw", "another instance (3)".
};

/// A library that is still mapped although its component is gone, or was never made ("image kept, held by X").
struct KeptImage {
  std::string node;             ///< "/camera"; the plugin's name if the constructor has not made a node yet.
  std::string plugin, library;  ///< As in ComponentInfo.
  std::string
      held_by;  ///< "2 messages of /camera/image_raw", "its constructor, which has not returned", "the process (...)"
};

}  // namespace nacelle::runtime
