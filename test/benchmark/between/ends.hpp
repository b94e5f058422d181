// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

namespace nacelle::bench {

/// How many messages have arrived, in memory that both processes see. The sender waits for each before it sends the next.
/// Threads: any, of any process.
class Arrivals {
 public:
  void add();
  void wait_for(std::uint32_t count);
  [[nodiscard]] std::uint32_t count() const { return count_.load(std::memory_order_acquire); }

 private:
  std::atomic<std::uint32_t> count_{0};
};

/// One way of moving messages of one size.
class SendingEnd {
 public:
  virtual ~SendingEnd() = default;
  [[nodiscard]] virtual bool is_connected() const = 0;
  /// Writes every byte of a message and sends it.
  virtual void send(std::uint8_t seed) = 0;
  /// Payload bytes that were copied on the way, and messages whose payload was lent, not copied.
  [[nodiscard]] virtual std::uint64_t bytes_copied() const { return 0; }
};
class ReceivingEnd {
 public:
  virtual ~ReceivingEnd() = default;
  [[nodiscard]] virtual std::uint64_t bytes_copied() const { return 0; }
};

// iceoryx as its own examples have it: loan, write, publish; a Listener that takes and releases.
[[nodiscard]] std::unique_ptr<SendingEnd> bare_sender(std::uint32_t bytes);
[[nodiscard]] std::unique_ptr<ReceivingEnd> bare_receiver(std::uint32_t bytes, Arrivals& arrivals);
/// The same in one thread, which takes what it has published. Returns how many arrived.
[[nodiscard]] std::uint64_t bare_in_one_thread(std::uint32_t bytes, std::uint64_t messages);
// The carrier of transport_iceoryx, messages and pools: borrow, prepare, write, send; decode, deliver, give back.
[[nodiscard]] std::unique_ptr<SendingEnd> carried_sender(std::uint32_t bytes, bool prepared);
[[nodiscard]] std::unique_ptr<ReceivingEnd> carried_receiver(std::uint32_t bytes, Arrivals& arrivals);

}  // namespace nacelle::bench
