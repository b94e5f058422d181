// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "nacelle/base/bytes.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle::record {

/// Returns whether all publishers of a topic keep their messages for late readers (transient_local).
[[nodiscard]] bool is_latched(const std::vector<QoS>& offered);
/// Returns how many messages of each publisher are kept: as many as the deepest publisher keeps, at most 100.
[[nodiscard]] std::size_t kept_depth(const std::vector<QoS>& offered);

/// The last encoded messages of each publisher of latched topics, as late readers get them.
///
/// Threads: one. Allocates: for each message.
class KeptMessages {
 public:
  struct Message {
    std::size_t topic = 0;
    std::uint64_t writer = 0;
    Bytes bytes;
  };
  /// Above so many bytes the oldest messages go.
  explicit KeptMessages(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  /// Keeps a message, of this publisher of the topic at most `depth`. One that is too long alone is left out, and those before it stay.
  void keep(std::size_t topic, std::uint64_t writer, ByteView bytes, std::size_t depth);
  /// Returns them in the order in which they came.
  [[nodiscard]] const std::deque<Message>& all() const { return messages_; }

 private:
  void forget(const std::deque<Message>::iterator& which);

  const std::size_t most_bytes_;
  std::size_t bytes_ = 0;
  std::deque<Message> messages_;
};

}  // namespace nacelle::record
