// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "nacelle/runtime/callback_group.hpp"

namespace nacelle::runtime {

inline constexpr MonotonicTime kNever{Duration::max()};

/// Timers ordered by due time: there is one deadline to sleep to, whatever their number.
///
/// A binary heap that knows each timer's place in it, so that firing and canceling cost O(log n).
/// Threads: under the executor's lock. Allocates: only while it grows.
class TimerQueue {
 public:
  /// Returns the earliest due time, or kNever.
  [[nodiscard]] MonotonicTime next_due() const { return next_due_; }
  /// Returns the timer that is due next. Precondition: the queue is not empty.
  [[nodiscard]] TimerBase& first() const { return *heap_.front(); }
  [[nodiscard]] std::size_t size() const { return heap_.size(); }
  /// Adds a timer, or changes its due time.
  void put(TimerBase& timer, MonotonicTime due);
  void remove(TimerBase& timer);

 private:
  [[nodiscard]] static bool comes_before(const TimerBase& a, const TimerBase& b);
  void set(std::size_t place, TimerBase& timer);
  void settle(std::size_t place);

  std::vector<TimerBase*> heap_;
  std::uint64_t added_ = 0;
  MonotonicTime next_due_ = kNever;
};

}  // namespace nacelle::runtime
