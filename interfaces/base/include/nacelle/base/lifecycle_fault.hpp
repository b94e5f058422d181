// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle {

/// Why components have not reached a state. Problem::where is the component or its line in the launch file, unless stated otherwise.
enum class LifecycleFault : std::uint8_t {
  TransitionFailed,  ///< A transition was refused, has failed, or has waited too long for what `after:` names. Value: the transition.
  NoSuchTransition,  ///< There is no transition of that name. Value: the name.
  OrderCircle,       ///< Components wait for each other. Where: a line of `after:`. Value: the first of them.
  Interrupted,  ///< A signal, a request or a fault ended the bring-up. Where: the bring-up. Value: the signal, if there is one.
};
[[nodiscard]] constexpr const char* code_text(LifecycleFault fault) {
  switch (fault) {
    case LifecycleFault::TransitionFailed: return "lifecycle.transition_failed";
    case LifecycleFault::NoSuchTransition: return "lifecycle.no_such_transition";
    case LifecycleFault::OrderCircle: return "lifecycle.order_circle";
    case LifecycleFault::Interrupted: return "lifecycle.interrupted";
  }
  return "";
}

}  // namespace nacelle
