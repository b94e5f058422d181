// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "nacelle/runtime/container.hpp"
#include "nacelle/runtime/futex.hpp"
#include "support/recipe.hpp"

namespace nacelle::bench {

/// A container with active components, as the program `nacelle` runs them: plugin, lifecycle gate, executor, supervisor.
/// Errors: what the container refuses, and a component that is faulted, ends the program with the words and code 1.
class Rig {
 public:
  /// `patience` above zero: a callback may block that long (and twice that) before it counts as late (and hung).
  explicit Rig(Duration patience = Duration{}, runtime::NodeInterfaces interfaces = runtime::NodeInterfaces::None);

  /// Loads, configures and activates. The recipe must outlive the rig.
  void add(const std::string& name, Recipe& recipe, const ThreadPolicy& thread = {});
  [[nodiscard]] runtime::Container& container() { return container_; }

 private:
  SystemClock clock_;
  runtime::Container container_;
};

/// Something that happens once, for a thread that waits for it. Not by atomic::wait(): libstdc++ yields up to four times before it
/// sleeps, so that a count of system calls would depend on which thread is quicker.
class Event {
 public:
  void set() {
    word_.store(1, std::memory_order_release);
    runtime::futex_wake(word_, std::numeric_limits<int>::max());
  }
  void wait() const {
    while (word_.load(std::memory_order_acquire) == 0) runtime::futex_wait(word_, 0);
  }
  void clear() { word_.store(0, std::memory_order_relaxed); }

 private:
  std::atomic<std::uint32_t> word_{0};
};

}  // namespace nacelle::bench
