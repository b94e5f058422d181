// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/runtime/component_info.hpp"

namespace nacelle::runtime {

/// A component that runs in another process and belongs to this container (Container::adopt).
/// Threads: any; trigger() and unload() wait for the other process, with a limit of their own.
class ForeignComponent {
 public:
  virtual ~ForeignComponent() = default;
  /// As it is now; the id is the container's to set. Must not wait.
  [[nodiscard]] virtual ComponentInfo info() const = 0;
  [[nodiscard]] virtual TransitionOutcome trigger(Transition transition) = 0;
  /// What moves something there hears no commands from now on, and its stop frame is written. Must not wait.
  virtual void stop_what_moves() = 0;
  /// From now on instead of the limit that its process has had. Must not wait.
  virtual void give_up_transitions_after(Duration limit) = 0;
  /// Ends it and its process. It is destroyed afterwards.
  virtual UnloadOutcome unload() = 0;
};

}  // namespace nacelle::runtime
