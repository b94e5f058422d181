// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <lifecycle_msgs/msg/state.hpp>
#include <nacelle_interfaces/msg/component.hpp>
#include <nacelle_interfaces/msg/fault.hpp>
#include <nacelle_interfaces/msg/fault_event.hpp>
#include <nacelle_interfaces/msg/problem.hpp>

#include "nacelle/base/problem.hpp"
#include "nacelle/runtime/component_info.hpp"

// Reports of a container as messages of nacelle_interfaces. Pure.
namespace nacelle::runtime {

[[nodiscard]] nacelle_interfaces::msg::Problem message_of(const Problem& problem);
[[nodiscard]] nacelle_interfaces::msg::Fault message_of(const FaultReason& fault);
[[nodiscard]] nacelle_interfaces::msg::FaultEvent message_of(const FaultEvent& event);
[[nodiscard]] lifecycle_msgs::msg::State message_of(StateId state);
[[nodiscard]] nacelle_interfaces::msg::Component message_of(const ComponentInfo& info);

}  // namespace nacelle::runtime
