// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <utility>

#include "nacelle/base/time.hpp"

namespace nacelle::runtime {

/// The time limit for component code; it may be shortened while a thread waits. Threads: any.
class Patience {
 public:
  Patience(Duration limit, const Clock& clock) : clock_(clock), limit_ns_(limit.count()) {}
  [[nodiscard]] Duration limit() const { return Duration{limit_ns_.load(std::memory_order_acquire)}; }
  [[nodiscard]] const Clock& clock() const { return clock_; }
  /// Changes the limit. A shorter one also applies to running waits. Returns false if it has this value already.
  bool set(Duration limit) {
    changed_at_ns_.store(clock_.now().nanoseconds(), std::memory_order_release);
    return limit_ns_.exchange(limit.count(), std::memory_order_acq_rel) != limit.count();
  }
  /// Sets a function that threads call every 20 ms while they wait. Call it while no thread waits.
  void call_while_waiting(std::function<void()> hook) { hook_ = std::move(hook); }
  void note_waiting() const {
    if (hook_) hook_();
  }
  [[nodiscard]] MonotonicTime changed_at() const {
    return MonotonicTime{Duration{changed_at_ns_.load(std::memory_order_acquire)}};
  }

 private:
  const Clock& clock_;
  std::atomic<Duration::rep> limit_ns_;
  std::atomic<std::int64_t> changed_at_ns_{INT64_MIN};
  std::function<void()> hook_;
};

/// The deadline of one wait, counted from its start, or from a change of the limit during the wait if that ends
/// earlier. futex_wait_until() with a clock reads it again often enough to apply such a change.
class Deadline {
 public:
  explicit Deadline(MonotonicTime fixed) : fixed_(fixed) {}
  explicit Deadline(const Patience& patience)
      : patience_(&patience), began_(patience.clock().now()), fixed_(began_ + patience.limit()) {}
  [[nodiscard]] MonotonicTime now() const {
    if (patience_ == nullptr || patience_->changed_at() <= began_) return fixed_;
    return std::min(fixed_, patience_->changed_at() + patience_->limit());
  }
  /// Call it in each turn of the wait.
  void note_waiting() const {
    if (patience_ != nullptr) patience_->note_waiting();
  }

 private:
  const Patience* patience_ = nullptr;
  MonotonicTime began_{}, fixed_;
};

}  // namespace nacelle::runtime
