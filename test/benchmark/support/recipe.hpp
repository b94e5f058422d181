// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

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
  /// What the component calls with each transition but the shutdown, on its executor: it returns why that fails, or nothing. Empty: none
  /// fails.
  [[nodiscard]] virtual std::function<std::string(Transition)> on_transition() { return {}; }
};

}  // namespace nacelle::bench
