// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::bench {

/// What a benchmark's component consists of. The component is a plugin, loaded, gated and run as every other; its code lies in
/// the program, so that the program can look at what it counts.
///
/// Ownership: the program's; it outlives the container. Threads: build() on the thread that loads.
class Recipe {
 public:
  Recipe() = default;
  Recipe(const Recipe&) = delete;
  Recipe& operator=(const Recipe&) = delete;
  virtual ~Recipe() = default;
  /// Makes publishers, subscriptions and timers; what it returns lives as long as the component.
  [[nodiscard]] virtual std::shared_ptr<void> build(LifecycleNode& node) = 0;
};

}  // namespace nacelle::bench
