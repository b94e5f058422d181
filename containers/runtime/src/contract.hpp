// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>

#include "nacelle/base/time.hpp"
#include "nacelle/host/message.hpp"

namespace nacelle::runtime {

/// Counts the periods that passed without a message. Exactly one period between two messages is not a miss. Starts with
/// the first message. Threads: the owner's lock.
class DeadlineWatch {
 public:
  /// Zero means no deadline.
  explicit DeadlineWatch(Duration period) : period_(period) {}
  [[nodiscard]] bool is_set() const { return period_ > Duration::zero(); }
  [[nodiscard]] bool is_running() const { return running_; }
  /// Returns the number of periods newly missed up to this message.
  std::uint64_t message(MonotonicTime now) {
    const std::uint64_t missed = look(now);
    last_ = now;
    counted_ = 0;
    running_ = true;
    return missed;
  }
  /// Returns the number of periods newly missed.
  std::uint64_t look(MonotonicTime now) {
    if (!running_ || now <= last_) return 0;
    const auto all = static_cast<std::uint64_t>((now - last_ - Duration{1}) / period_);
    if (all <= counted_) return 0;
    const std::uint64_t missed = all - counted_;
    counted_ = all;
    return missed;
  }
  void stop() { running_ = false; }
  /// Returns when the next check can find a miss.
  [[nodiscard]] MonotonicTime due() const {
    return running_ ? last_ + period_ * static_cast<Duration::rep>(counted_ + 1) + Duration{1} : kNeverExpires;
  }

 private:
  Duration period_;
  MonotonicTime last_;
  std::uint64_t counted_ = 0;
  bool running_ = false;
};

/// Tracks whether a writer with liveliness manual_by_topic is alive. Alive from the start. Threads: the owner's lock.
class LeaseWatch {
 public:
  /// Zero means that the lease never expires.
  LeaseWatch(Duration lease, MonotonicTime now) : lease_(lease), last_(now) {}
  [[nodiscard]] bool is_set() const { return lease_ > Duration::zero(); }
  [[nodiscard]] bool is_alive() const { return alive_; }
  /// Records a sign of life. Returns true if the lease had expired.
  bool show_life(MonotonicTime now) {
    last_ = now;
    return !std::exchange(alive_, true);
  }
  /// Returns true if the lease has just expired.
  bool look(MonotonicTime now) { return is_set() && alive_ && now - last_ > lease_ && std::exchange(alive_, false); }
  [[nodiscard]] MonotonicTime due() const { return is_set() && alive_ ? last_ + lease_ + Duration{1} : kNeverExpires; }

 private:
  Duration lease_;
  MonotonicTime last_;
  bool alive_ = true;
};

}  // namespace nacelle::runtime
