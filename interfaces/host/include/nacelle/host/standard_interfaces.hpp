// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

// Topics and services that every ROS 2 node has because tools expect them. Lists of a robot's streams leave them
// out. Source: rclcpp (jazzy), parameter_service_names.hpp, node_type_descriptions.cpp; rcl_lifecycle, com_interface.c.
namespace nacelle {

inline constexpr const char* kRosoutTopic = "/rosout";
inline constexpr const char* kParameterEventsTopic = "/parameter_events";

/// Behind a node's name and a slash; of every node.
inline constexpr std::array<std::string_view, 7> kNodeServices{
    "describe_parameters", "get_parameter_types", "get_parameters",           "get_type_description",
    "list_parameters",     "set_parameters",      "set_parameters_atomically"};
/// The same of a lifecycle node.
inline constexpr std::array<std::string_view, 5> kLifecycleServices{
    "change_state", "get_available_states", "get_available_transitions", "get_state", "get_transition_graph"};

/// One that every node, or every lifecycle node, publishes.
[[nodiscard]] inline bool is_standard_topic(std::string_view topic) {
  return topic == kRosoutTopic || topic == kParameterEventsTopic || topic.ends_with("/transition_event");
}

/// The names of a node's standard services.
[[nodiscard]] inline std::vector<std::string> standard_services(const std::string& node, bool managed) {
  std::vector<std::string> names;
  const auto add = [&](std::string_view name) { names.push_back(node + "/" + std::string(name)); };
  std::ranges::for_each(kNodeServices, add);
  if (managed) std::ranges::for_each(kLifecycleServices, add);
  return names;
}

}  // namespace nacelle
