// SPDX-License-Identifier: Apache-2.0
#include "nacelle/host/lifecycle_state.hpp"

namespace nacelle {

const char* to_text(StateId state) {
  switch (state) {
    case StateId::Unknown: return "unknown";
    case StateId::Unconfigured: return "unconfigured";
    case StateId::Inactive: return "inactive";
    case StateId::Active: return "active";
    case StateId::Finalized: return "finalized";
    case StateId::Configuring: return "configuring";
    case StateId::CleaningUp: return "cleaningup";
    case StateId::ShuttingDown: return "shuttingdown";
    case StateId::Activating: return "activating";
    case StateId::Deactivating: return "deactivating";
    case StateId::ErrorProcessing: return "errorprocessing";
  }
  return "unknown";
}

const char* to_text(Transition transition) {
  switch (transition) {
    case Transition::Configure: return "configure";
    case Transition::Cleanup: return "cleanup";
    case Transition::Activate: return "activate";
    case Transition::Deactivate: return "deactivate";
    case Transition::Shutdown: return "shutdown";
  }
  return "unknown";
}

bool parse_transition(std::string_view text, Transition& transition) {
  for (const auto candidate : {Transition::Configure, Transition::Cleanup, Transition::Activate, Transition::Deactivate,
                               Transition::Shutdown}) {
    if (text == to_text(candidate)) {
      transition = candidate;
      return true;
    }
  }
  return false;
}

}  // namespace nacelle
