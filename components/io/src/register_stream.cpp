// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/register_stream.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "nacelle/base/expect.hpp"

namespace nacelle::io {
namespace {

std::size_t room_for(const std::vector<PollBlock>& blocks) {
  std::size_t bytes = 0;
  for (const auto& block : blocks) {
    NACELLE_EXPECT(!block.fill || (block.length > 0 && block.most >= block.length),
                   "a FIFO needs a record and a limit");
    bytes += RegisterStream::kHeaderBytes + (block.fill ? block.most : block.length);
  }
  return bytes;
}

}  // namespace

RegisterStream::RegisterStream(std::unique_ptr<RegisterBus> bus, std::vector<PollBlock> blocks, Duration period,
                               const Clock& clock)
    : bus_(std::move(bus)),
      blocks_(std::move(blocks)),
      period_(period),
      clock_(clock),
      next_(clock.now() + period),
      buffer_(room_for(blocks_)) {
  NACELLE_EXPECT(period > Duration::zero(), "a device is polled with a period");
}

ByteSpan RegisterStream::append(std::uint8_t tag, std::size_t length) {
  std::uint8_t* const at = buffer_.data() + used_;
  at[0] = tag;
  store_le16(at + 1, static_cast<std::uint16_t>(length));
  used_ += kHeaderBytes + length;
  return {at + kHeaderBytes, length};
}

Result<void, StreamFault> RegisterStream::read(const PollBlock& block, std::uint8_t reg, ByteSpan in) {
  const auto first = read_registers(*bus_, block.address, reg, in);
  if (first || first.error() == StreamFault::BusStuck || first.error() == StreamFault::HungUp) return first;
  const auto second = read_registers(*bus_, block.address, reg, in);
  if (second) retries_.fetch_add(1, std::memory_order_relaxed);
  return second;
}

Result<std::size_t, StreamFault> RegisterStream::level(const PollBlock& block) {
  std::array<std::uint8_t, 2> bytes{};
  const std::size_t count = block.fill->has_two_bytes ? 2 : 1;
  if (auto done = read(block, block.fill->reg, ByteSpan{bytes}.first(count)); !done) return err(done.error());
  const unsigned value = count == 1               ? bytes[0]
                         : block.fill->big_endian ? unsigned{bytes[0]} << 8U | bytes[1]
                                                  : unsigned{bytes[1]} << 8U | bytes[0];
  return std::size_t{value & block.fill->mask} * block.fill->unit;
}

Result<void, StreamFault> RegisterStream::poll() {
  used_ = 0;
  for (const auto& block : blocks_) {
    const std::size_t before = used_;
    Result<void, StreamFault> done{};
    if (!block.fill) {
      done = read(block, block.reg, append(block.tag, block.length));
    } else {
      const auto bytes = level(block);
      if (!bytes) return err(bytes.error());
      if (block.full > 0 && *bytes >= block.full) {
        append(block.tag | kOverflowBit, 0);
        return err(StreamFault::ReadFailed);
      }
      const std::size_t whole = std::min<std::size_t>(*bytes, block.most) / block.length * block.length;
      if (whole > 0) done = read_registers(*bus_, block.address, block.reg, append(block.tag, whole));
    }
    if (!done) {
      used_ = before;
      return done;
    }
  }
  return {};
}

Result<ByteView, StreamFault> RegisterStream::read_until(MonotonicTime deadline) {
  if (is_away()) return err(StreamFault::NotFound);
  if (fault_) return err(*std::exchange(fault_, {}));
  for (;;) {
    if (!bus_->wait_until(std::min(next_, deadline))) return ByteView{};
    const MonotonicTime now = clock_.now();
    if (now < next_) return ByteView{};
    // At a steady pace, but polls that were missed are not made up for.
    next_ = std::max(next_ + period_, now);
    const auto done = poll();
    // What was read before the fault comes first.
    if (!done && used_ == 0) return err(done.error());
    if (!done) fault_ = done.error();
    if (used_ > 0) return ByteView{buffer_.data(), used_};
    if (now >= deadline) return ByteView{};
  }
}

Result<void, StreamFault> RegisterStream::reopen() {
  if (auto opened = bus_->reopen(); !opened) return opened;
  fault_.reset();
  lost_ = false;
  next_ = clock_.now() + period_;
  return {};
}

}  // namespace nacelle::io
