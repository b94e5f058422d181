// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "nacelle/io/register_bus.hpp"

namespace nacelle::io {

/// Registers that are read at each poll. With `fill` it is a FIFO: so many bytes as its level says.
struct PollBlock {
  struct Fill {
    std::uint8_t reg = 0;         ///< Where the level stands ...
    bool has_two_bytes = true;    ///< ... one register or two ...
    bool big_endian = true;       ///< ... the more significant one first, or last ...
    std::uint16_t mask = 0xFFFF;  ///< ... these bits of them ...
    std::uint16_t unit = 1;       ///< ... in this many bytes.
  };
  std::uint8_t tag = 0;  ///< Of the block in the stream.
  std::uint8_t address = 0;
  std::uint8_t reg = 0;
  std::uint16_t length = 0;  ///< Bytes of the block; of a FIFO: of one record.
  std::optional<Fill> fill{};
  std::uint16_t most = 0;  ///< A FIFO: bytes per poll at most, whole records.
  /// A FIFO: a level from which on records may have been lost and cut; 0: never. The block is then empty, with kOverflowBit in its tag,
  /// and read_until() fails with ReadFailed at the next poll, so that the reader sets the device up anew.
  std::uint16_t full = 0;
};

/// A device with registers as a stream: polled at a steady pace, each answer a block of the stream.
///
///     offset  bytes  field
///          0      1  tag       PollBlock::tag, with 0x80: the FIFO was full, and what it held is lost
///          1      2  length    little-endian
///          3      n  bytes     as the device sent them
///
/// A transfer that fails is tried once more and counted, except for the bytes of a FIFO: what a broken read took out is gone, and
/// the next one would begin inside a record.
/// Threads: as ByteStream; no writes (the caller sets the device up through bus() while no thread reads, or on that thread).
class RegisterStream final : public ByteStream {
 public:
  static constexpr std::uint8_t kOverflowBit = 0x80;
  static constexpr std::size_t kHeaderBytes = 3;

  /// Precondition: the period is positive; FIFOs have `most` and `length`.
  RegisterStream(std::unique_ptr<RegisterBus> bus, std::vector<PollBlock> blocks, Duration period, const Clock& clock);

  [[nodiscard]] Result<ByteView, StreamFault> read_until(MonotonicTime deadline) override;
  /// Errors: always WriteFailed.
  [[nodiscard]] Result<void, StreamFault> write(ByteView) override { return err(StreamFault::WriteFailed); }
  void interrupt() noexcept override { bus_->interrupt(); }
  [[nodiscard]] Result<void, StreamFault> reopen() override;
  [[nodiscard]] bool is_away() const noexcept override {
    return lost_.load(std::memory_order_relaxed) || bus_->is_away();
  }
  [[nodiscard]] int descriptor() const noexcept override { return -1; }

  [[nodiscard]] RegisterBus& bus() { return *bus_; }
  /// The device did not answer when it was set up: everything fails with NotFound until reopen(). Before reading starts.
  void start_away() { lost_ = true; }
  /// Transfers that worked when they were tried again.
  [[nodiscard]] std::uint64_t retries() const { return retries_.load(std::memory_order_relaxed); }

 private:
  [[nodiscard]] Result<void, StreamFault> poll();
  [[nodiscard]] Result<void, StreamFault> read(const PollBlock& block, std::uint8_t reg, ByteSpan in);
  [[nodiscard]] Result<std::size_t, StreamFault> level(const PollBlock& block);
  /// Room for a block's bytes behind its header.
  ByteSpan append(std::uint8_t tag, std::size_t length);

  std::unique_ptr<RegisterBus> bus_;
  const std::vector<PollBlock> blocks_;
  const Duration period_;
  const Clock& clock_;
  MonotonicTime next_;
  Bytes buffer_;
  std::size_t used_ = 0;
  std::optional<StreamFault> fault_{};  // of the last poll, told after its bytes
  std::atomic<bool> lost_{false};
  std::atomic<std::uint64_t> retries_{0};
};

}  // namespace nacelle::io
