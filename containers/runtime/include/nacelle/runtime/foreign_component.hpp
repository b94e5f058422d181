// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

/// A component that runs in another process and belongs to this container (Container::adopt).
/// Threads: any; trigger() and unload() wait for the other process, with a limit of their own.
class ForeignComponent {
 public:
  virtual ~ForeignComponent() = default;
  /// As it is now; the id is the container's to set. Must not wait.
  [[nodiscard]] virtual ComponentInfo info() const = 0;
  [[nodiscard]] virtual TransitionOutcome trigger(Transition transition) = 0;
  /// Ends it and its process. It is destroyed afterwards.
  virtual UnloadOutcome unload() = 0;
};

}  // namespace nacelle::runtime
