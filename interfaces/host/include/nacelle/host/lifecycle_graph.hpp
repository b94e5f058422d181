// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "nacelle/host/lifecycle_state.hpp"

// The state machine of lifecycle nodes as lifecycle_msgs defines it, in rcl_lifecycle's order.
// Source: rcl_lifecycle (jazzy), default_state_machine.c.
namespace nacelle {

/// One transition: asked for (ids below 10), or what its callback has returned.
struct LifecycleEdge {
  std::uint8_t id;
  const char* label;
  StateId start, goal;
};

inline constexpr std::array<StateId, 11> kLifecycleStates{
    StateId::Unknown,    StateId::Unconfigured, StateId::Inactive,       StateId::Active,
    StateId::Finalized,  StateId::Configuring,  StateId::CleaningUp,     StateId::ShuttingDown,
    StateId::Activating, StateId::Deactivating, StateId::ErrorProcessing};

inline constexpr std::array<LifecycleEdge, 25> kLifecycleGraph{{
    {1, "configure", StateId::Unconfigured, StateId::Configuring},
    {10, "transition_success", StateId::Configuring, StateId::Inactive},
    {11, "transition_failure", StateId::Configuring, StateId::Unconfigured},
    {12, "transition_error", StateId::Configuring, StateId::ErrorProcessing},
    {2, "cleanup", StateId::Inactive, StateId::CleaningUp},
    {20, "transition_success", StateId::CleaningUp, StateId::Unconfigured},
    {21, "transition_failure", StateId::CleaningUp, StateId::Inactive},
    {22, "transition_error", StateId::CleaningUp, StateId::ErrorProcessing},
    {3, "activate", StateId::Inactive, StateId::Activating},
    {30, "transition_success", StateId::Activating, StateId::Active},
    {31, "transition_failure", StateId::Activating, StateId::Inactive},
    {32, "transition_error", StateId::Activating, StateId::ErrorProcessing},
    {4, "deactivate", StateId::Active, StateId::Deactivating},
    {40, "transition_success", StateId::Deactivating, StateId::Inactive},
    {41, "transition_failure", StateId::Deactivating, StateId::Active},
    {42, "transition_error", StateId::Deactivating, StateId::ErrorProcessing},
    {5, "shutdown", StateId::Unconfigured, StateId::ShuttingDown},
    {6, "shutdown", StateId::Inactive, StateId::ShuttingDown},
    {7, "shutdown", StateId::Active, StateId::ShuttingDown},
    {50, "transition_success", StateId::ShuttingDown, StateId::Finalized},
    {51, "transition_failure", StateId::ShuttingDown, StateId::Finalized},
    {52, "transition_error", StateId::ShuttingDown, StateId::ErrorProcessing},
    {60, "transition_success", StateId::ErrorProcessing, StateId::Unconfigured},
    {61, "transition_failure", StateId::ErrorProcessing, StateId::Finalized},
    {62, "transition_error", StateId::ErrorProcessing, StateId::Finalized},
}};

}  // namespace nacelle
