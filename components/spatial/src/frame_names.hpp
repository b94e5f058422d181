// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace nacelle::spatial {

/// Names to numbers 1, 2, ... and back; never forgets.
/// Threads: find() and name() any time without a lock; add() from one thread at a time.
class [[gnu::visibility("hidden")]] FrameNames {
 public:
  explicit FrameNames(std::size_t capacity);
  /// 0 if unknown. Allocates: nothing.
  [[nodiscard]] std::uint32_t find(std::string_view name) const;
  /// 0 if the table is full.
  [[nodiscard]] std::uint32_t add(std::string_view name);
  [[nodiscard]] std::string_view name(std::uint32_t id) const;
  [[nodiscard]] std::uint32_t size() const { return size_.load(std::memory_order_acquire); }

 private:
  std::size_t capacity_;
  std::size_t mask_;
  std::vector<std::string> names_;  // names_[id - 1], each written once before its slot is published
  std::unique_ptr<std::atomic<std::uint32_t>[]> slots_;  // open addressing, at most half full
  std::atomic<std::uint32_t> size_{0};
};

}  // namespace nacelle::spatial
