// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::simulation {

/// Lets bytes out as slowly as a serial line carries them.
///
/// They come in chunks, as a USB bridge hands them over: 64 bytes at a time, or fewer when the line falls silent.
/// Source: the bulk packet of full-speed USB bridges (CP2102, CH340) has 64 bytes.
class PacedLine {
 public:
  explicit PacedLine(unsigned baud) : byte_time_(10'000'000'000LL / baud) {}

  /// Queues bytes. The first leaves at `now`, or after those that are already queued. Bytes that do not fit are lost and counted:
  /// a device's transmit buffer is small, and a host that requests endless echoes must not fill this one.
  void send(Duration now, ByteView bytes) {
    if (queue_.size() + bytes.size() > kLongestQueue) {
      lost_ += bytes.size();
      return;
    }
    free_at_ = std::max(free_at_, now) + byte_time_ * static_cast<std::int64_t>(bytes.size());
    queue_.insert(queue_.end(), bytes.begin(), bytes.end());
  }
  /// When the last queued byte has left.
  [[nodiscard]] Duration free_at() const { return free_at_; }

  /// Calls `deliver(ByteView)` with the bytes that have left by now and were not delivered yet.
  template <typename Deliver>
  void release(Duration now, Deliver&& deliver) {
    std::size_t gone = queue_.size();
    if (now < free_at_) {
      const auto waiting = static_cast<std::size_t>((free_at_ - now + byte_time_ - Duration{1}) / byte_time_);
      gone = waiting >= queue_.size() ? 0 : (queue_.size() - waiting) / kChunk * kChunk;
    }
    if (gone == 0) return;
    deliver(ByteView{queue_.data(), gone});
    queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(gone));
  }

  /// Bytes that found the queue full.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

  static constexpr std::size_t kChunk = 64, kLongestQueue = 4096;

 private:
  Duration byte_time_;
  Duration free_at_{};
  Bytes queue_;
  std::uint64_t lost_ = 0;
};

}  // namespace nacelle::simulation
