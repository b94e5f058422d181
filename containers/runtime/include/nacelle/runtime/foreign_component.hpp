// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/runtime/component_info.hpp"

namespace nacelle::runtime {

/// A component that runs in another process and belongs to this container (Container::adopt).
/// Threads: any; trigger() and unload() wait for the other process, with a limit of their own.
class ForeignComponent {
 public:
  virtual ~ForeignComponent() = default;
  /// Returns its present state; the container sets the id. Must not wait.
  [[nodiscard]] virtual ComponentInfo info() const = 0;
  /// Returns the request that loaded it, with its parameters as they are now. Must not wait.
  [[nodiscard]] virtual LoadRequest request() const = 0;
  [[nodiscard]] virtual TransitionOutcome trigger(Transition transition) = 0;
  /// Makes a component that moves something ignore commands from now on, and writes its stop frame. Must not wait.
  virtual void stop_what_moves() = 0;
  /// Replaces the time limit of its process. Must not wait.
  virtual void give_up_transitions_after(Duration limit) = 0;
  /// Ends the component and its process. This object is destroyed afterwards.
  virtual UnloadOutcome unload() = 0;
};

}  // namespace nacelle::runtime
