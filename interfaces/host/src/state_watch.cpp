// SPDX-License-Identifier: Apache-2.0
#include "nacelle/host/state_watch.hpp"

#include <utility>

namespace nacelle {
namespace {
thread_local StateWatch* watch_of_this_thread = nullptr;
}

StateWatch::StateWatch(OnState on_state)
    : on_state_(std::move(on_state)), outer_(std::exchange(watch_of_this_thread, this)) {}
StateWatch::~StateWatch() { watch_of_this_thread = outer_; }

void StateWatch::tell(StateId from, StateId to) {
  if (watch_of_this_thread != nullptr) watch_of_this_thread->on_state_(from, to);
}

}  // namespace nacelle
