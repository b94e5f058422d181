// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "nacelle/runtime/container.hpp"
#include "support/recipe.hpp"

namespace nacelle::bench {

/// A container with active components, as the program `nacelle` runs them: plugin, lifecycle gate, executor, supervisor.
/// Errors: what the container refuses, and a component that is faulted, ends the program with the words and code 1.
class Rig {
 public:
  /// `patience` above zero: a callback may block that long (and twice that) before it counts as late (and hung).
  explicit Rig(Duration patience = Duration{}, runtime::NodeInterfaces interfaces = runtime::NodeInterfaces::None);

  /// Loads, configures and activates. The recipe must outlive the rig.
  void add(const std::string& name, Recipe& recipe, const runtime::ThreadPolicy& thread = {});
  [[nodiscard]] runtime::Container& container() { return container_; }

 private:
  SystemClock clock_;
  runtime::Container container_;
};

/// Something that happens once, for a thread that waits for it.
class Event {
 public:
  void set() {
    word_.store(1, std::memory_order_release);
    word_.notify_all();
  }
  void wait() const { word_.wait(0, std::memory_order_acquire); }
  void clear() { word_.store(0, std::memory_order_relaxed); }

 private:
  std::atomic<std::uint32_t> word_{0};
};

}  // namespace nacelle::bench
