// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>

#include "diff_drive/model/drive_command.hpp"
#include "diff_drive/model/latest_value.hpp"

namespace nacelle::diff_drive {

/// What the executor's callbacks leave for the control loop, without either waiting for the other.
///
/// Threads: the executor writes, the loop takes. Allocates: nothing after it was made.
struct CommandInbox {
  static constexpr std::int64_t kNever = INT64_MIN;

  struct Source {
    LatestValue<DriveCommand> commands;
    std::atomic<std::int64_t> refused_at_ns{kNever};  ///< When a command was refused last, CLOCK_MONOTONIC.
  };
  struct Lock {
    std::atomic<bool> locked{false};
    std::atomic<std::int64_t> heard_at_ns{kNever};
  };

  /// Something that holds the wheels still while it is set.
  struct HoldFlag {
    std::atomic<bool> is_set{false};
    std::atomic<std::int64_t> released_at_ns{0};  ///< When it became false; written before it.
    void set() { is_set.store(true, std::memory_order_release); }
    void release(MonotonicTime now) {
      released_at_ns.store(now.nanoseconds());
      is_set.store(false, std::memory_order_release);
    }
  };

  explicit CommandInbox(std::size_t source_count = 1, std::size_t lock_count = 0)
      : sources(source_count), locks(lock_count) {}

  std::deque<Source> sources;  // a deque: its elements neither copy nor move
  std::deque<Lock> locks;
  HoldFlag emergency_stop;
  HoldFlag unguarded;
  HoldFlag inactive;                              ///< The controller that follows commands is not active.
  std::atomic<bool> without_joint_states{false};  ///< The joint states are not published.
  /// How often one of these two was set or released. Written after them; see DriveLoop::orders_followed().
  std::atomic<std::uint32_t> orders{0};
  /// How often the base was stopped from outside of its component; null: never. Outlives the loop.
  const std::atomic<std::uint64_t>* stops_from_outside = nullptr;
};

}  // namespace nacelle::diff_drive
