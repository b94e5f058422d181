// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>

#include "imu/protocol/bno055_uart.hpp"
#include "nacelle/io/register_bus.hpp"

namespace nacelle::imu {

/// The registers of a BNO055 over its serial line. Addresses are not used: one device is on the line.
///
/// A bus overrun, an answer of a wrong length and silence are tried again, four times in all; then it is NoAnswer.
class Bno055Line final : public io::RegisterBus {
 public:
  Bno055Line(std::unique_ptr<io::ByteStream> line, const Clock& clock) : line_(std::move(line)), clock_(clock) {}

  /// `out` is a register and at most one value. Errors: as RegisterBus; ReadFailed and WriteFailed if the device refuses.
  [[nodiscard]] Result<void, io::StreamFault> transfer(std::uint8_t address, ByteView out, ByteSpan in) override;
  [[nodiscard]] bool wait_until(MonotonicTime time) override;
  void interrupt() noexcept override {
    is_interrupted_.store(true, std::memory_order_relaxed);
    line_->interrupt();
  }
  [[nodiscard]] Result<void, io::StreamFault> reopen() override;
  [[nodiscard]] bool is_away() const noexcept override { return line_->is_away(); }

  /// An answer takes 1 ms and 4 ms of line at 115200 baud; a device in reset takes longer.
  static constexpr Duration kPatience = 30ms;
  static constexpr int kAttempts = 4;

 private:
  enum class Outcome : std::uint8_t { Done, Again, Refused };
  [[nodiscard]] Result<Outcome, io::StreamFault> ask(ByteView request, ByteSpan in);

  std::unique_ptr<io::ByteStream> line_;
  const Clock& clock_;
  Bno055AnswerDecoder decoder_;
  std::atomic<bool> is_interrupted_{false};
};

}  // namespace nacelle::imu
