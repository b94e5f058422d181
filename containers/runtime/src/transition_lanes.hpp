// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>

#include "errand.hpp"
#include "nacelle/base/guarded.hpp"

namespace nacelle::runtime {

/// Transitions that somebody has asked for and waits for elsewhere: those of one node one after the other, those of several beside
/// each other. There is a thread for a node as long as one of its transitions is under way.
/// Threads: any.
class TransitionLanes {
 public:
  /// Nobody asks for so many transitions of one node at once.
  static constexpr std::size_t kMostWaiting = 16;

  TransitionLanes() = default;
  /// Drops what waits, and waits for what runs.
  ~TransitionLanes();
  TransitionLanes(const TransitionLanes&) = delete;
  TransitionLanes& operator=(const TransitionLanes&) = delete;

  /// False: too many wait already.
  [[nodiscard]] bool push(std::uint64_t node, std::function<void()> job);
  /// The node goes: what waits is dropped. Waits for nothing.
  void drop(std::uint64_t node);

 private:
  struct Lane {
    std::deque<std::function<void()>> waiting;
    bool busy = false;  // the errand is still to come back here
    std::unique_ptr<Errand> errand;
  };
  using Lanes = std::map<std::uint64_t, Lane>;
  void work(Lane& lane);
  static void sweep(Lanes& lanes);

  Guarded<Lanes> lanes_;
};

}  // namespace nacelle::runtime
