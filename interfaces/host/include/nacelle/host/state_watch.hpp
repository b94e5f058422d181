// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "nacelle/host/lifecycle_state.hpp"

namespace nacelle {

/// Hears of each state that a node enters in the transitions that this thread runs while it lives: what the container makes
/// ~/transition_event of. Nested ones replace each other. Threads: the one that makes it.
class StateWatch final {
 public:
  using OnState = std::function<void(StateId from, StateId to)>;
  explicit StateWatch(OnState on_state);
  ~StateWatch();
  StateWatch(const StateWatch&) = delete;
  StateWatch& operator=(const StateWatch&) = delete;

  /// What LifecycleNode calls.
  static void tell(StateId from, StateId to);

 private:
  const OnState on_state_;
  StateWatch* const outer_;
};

}  // namespace nacelle
