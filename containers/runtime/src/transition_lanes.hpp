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

/// Runs requested transitions while the requester waits on another thread: those of one node one after the other, those
/// of several nodes in parallel. A node has a thread as long as one of its transitions runs.
/// Threads: any.
class TransitionLanes {
 public:
  /// The most transitions of one node that may wait.
  static constexpr std::size_t kMostWaiting = 16;

  TransitionLanes() = default;
  /// Drops waiting transitions, and waits for running ones.
  ~TransitionLanes();
  TransitionLanes(const TransitionLanes&) = delete;
  TransitionLanes& operator=(const TransitionLanes&) = delete;

  /// Returns false if too many wait already.
  [[nodiscard]] bool push(std::uint64_t node, std::function<void()> job);
  /// Drops the waiting transitions of a node that is being unloaded. Does not block.
  void drop(std::uint64_t node);

 private:
  struct Lane {
    std::deque<std::function<void()>> waiting;
    bool busy = false;  // the errand has not returned yet
    std::unique_ptr<Errand> errand;
  };
  using Lanes = std::map<std::uint64_t, Lane>;
  void work(Lane& lane);
  static void sweep(Lanes& lanes);

  Guarded<Lanes> lanes_;
};

}  // namespace nacelle::runtime
