// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::look {

/// A message's bytes, made once for all viewers.
struct Encoded {
  std::uint64_t time = 0;  ///< Nanoseconds since the epoch.
  Bytes bytes;
};

/// What waits to be sent to one viewer, and how much of it may go now.
///
/// Messages are bounded by a budget of bytes a second; what exceeds it is dropped: of one subscription the newest is kept if it is large
/// (a picture, a scan), else the newest kSmallBytes. Answers are not dropped; a viewer that does not read them is given up.
/// Threads: one. Allocates: with what it holds.
class Outbox {
 public:
  static constexpr std::size_t kSmallBytes = std::size_t{32} << 10U;  ///< Of one subscription.
  static constexpr std::size_t kMostAnswers = std::size_t{8} << 20U;  ///< Bytes, but for a single one.

  /// `bytes_per_second`: of messages; 0: as many as the connection takes.
  explicit Outbox(std::uint64_t bytes_per_second) : rate_(bytes_per_second) {}

  /// Returns false if too many answers wait: the viewer does not read.
  [[nodiscard]] bool answer(bool is_binary, Bytes bytes);
  void message(std::uint32_t subscription, std::shared_ptr<const Encoded> message);
  /// Drops what waits of it.
  void forget(std::uint32_t subscription);

  struct Item {
    bool is_binary = true;
    Bytes answer;
    std::uint32_t subscription = 0;
    std::shared_ptr<const Encoded> message;  ///< null: an answer
  };
  /// Returns what is next: answers first. Nothing: there is none, or the budget is used up.
  [[nodiscard]] std::optional<Item> next(MonotonicTime now);
  /// Whether next() would return something. Messages that wait for the budget do not count.
  [[nodiscard]] bool has_next(MonotonicTime now);
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }

 private:
  void refill(MonotonicTime now);

  const std::uint64_t rate_;
  double allowance_ = 0.0;  // bytes; below zero after a message that was larger
  MonotonicTime filled_{};
  std::deque<Item> answers_, messages_;
  std::size_t answer_bytes_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace nacelle::look
