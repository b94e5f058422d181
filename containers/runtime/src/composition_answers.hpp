// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <composition_interfaces/srv/list_nodes.hpp>
#include <composition_interfaces/srv/load_node.hpp>
#include <composition_interfaces/srv/unload_node.hpp>
#include <nacelle_interfaces/srv/change_state.hpp>
#include <nacelle_interfaces/srv/get_components.hpp>
#include <nacelle_interfaces/srv/load_component.hpp>
#include <nacelle_interfaces/srv/unload_component.hpp>

#include "nacelle/runtime/composition_host.hpp"
#include "nacelle/runtime/container.hpp"

// The answers of the services of a container's node (container_services.hpp).
// Errors: throws only std::exception, whose text is the answer.
namespace nacelle::runtime {

/// The container, and the host that loads and unloads for it.
struct Composed {
  Container& container;
  CompositionHost& host;
};

// Services of rclcpp's component_container. Source: rclcpp_components (jazzy), component_manager.cpp.
void answer(Composed& composed, const composition_interfaces::srv::LoadNode::Request& request,
            composition_interfaces::srv::LoadNode::Response& response);
void answer(Composed& composed, const composition_interfaces::srv::UnloadNode::Request& request,
            composition_interfaces::srv::UnloadNode::Response& response);
void answer(Composed& composed, const composition_interfaces::srv::ListNodes::Request& request,
            composition_interfaces::srv::ListNodes::Response& response);
// Nacelle's own services.
void answer(Composed& composed, const nacelle_interfaces::srv::GetComponents::Request& request,
            nacelle_interfaces::srv::GetComponents::Response& response);
void answer(Composed& composed, const nacelle_interfaces::srv::LoadComponent::Request& request,
            nacelle_interfaces::srv::LoadComponent::Response& response);
void answer(Composed& composed, const nacelle_interfaces::srv::UnloadComponent::Request& request,
            nacelle_interfaces::srv::UnloadComponent::Response& response);
/// Waits for the transition.
void answer(Container& container, const nacelle_interfaces::srv::ChangeState::Request& request,
            nacelle_interfaces::srv::ChangeState::Response& response);

}  // namespace nacelle::runtime
