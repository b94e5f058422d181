// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>

namespace nacelle::transport_dds {

/// A queue that grows up to its limit.
/// Threads: one at a time. Allocates: when it holds more entries than ever before. Errors: see push().
template <typename T>
class SampleRing {
 public:
  explicit SampleRing(std::size_t limit) : limit_(limit == 0 ? 1 : limit) {}

  enum class Pushed : unsigned char { Fine, Overwrote, Full };
  /// Adds an entry at the end. If there is no room or no memory, `overwrite` replaces the oldest entry and moves it to
  /// `entry`; otherwise `entry` stays unchanged.
  [[nodiscard]] Pushed push(T& entry, bool overwrite) noexcept {
    Pushed did = Pushed::Fine;
    if (count_ == room_ && !grow()) {
      if (!overwrite || count_ == 0) return Pushed::Full;
      T oldest = pop();
      put(std::move(entry));
      entry = std::move(oldest);
      did = Pushed::Overwrote;
    } else {
      put(std::move(entry));
    }
    return did;
  }
  /// Preconditions: not empty.
  [[nodiscard]] T pop() noexcept {
    T first = std::move(entries_[first_]);
    first_ = (first_ + 1) % room_;
    --count_;
    return first;
  }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] std::size_t size() const { return count_; }

 private:
  void put(T&& entry) noexcept {
    entries_[(first_ + count_) % room_] = std::move(entry);
    ++count_;
  }
  [[nodiscard]] bool grow() noexcept {
    if (room_ == limit_) return false;
    const std::size_t more = room_ == 0 ? (limit_ < 8 ? limit_ : 8) : (room_ > limit_ / 2 ? limit_ : 2 * room_);
    std::unique_ptr<T[]> bigger{new (std::nothrow) T[more]};
    if (!bigger) return false;
    for (std::size_t i = 0; i < count_; ++i) bigger[i] = std::move(entries_[(first_ + i) % room_]);
    entries_ = std::move(bigger);
    first_ = 0;
    room_ = more;
    return true;
  }

  const std::size_t limit_;
  std::unique_ptr<T[]> entries_;
  std::size_t room_ = 0, first_ = 0, count_ = 0;
};

}  // namespace nacelle::transport_dds
