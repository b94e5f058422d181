// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/io/byte_stream.hpp"

namespace nacelle::io {

/// A bus whose devices have registers: I2C, or a serial line that carries register reads and writes.
///
/// Threads: one at a time; interrupt() from any thread at any time. Allocates: nothing after it was made.
class RegisterBus {
 public:
  RegisterBus() = default;
  RegisterBus(const RegisterBus&) = delete;
  RegisterBus& operator=(const RegisterBus&) = delete;
  virtual ~RegisterBus() = default;

  /// One transaction with the device at a 7-bit address: `out` is written, then `in` is filled, without a stop between
  /// them. Either may be empty. On I2C the first byte of `out` is the register.
  /// Errors: NoAnswer, BusStuck, HungUp, NotFound, ReadFailed, WriteFailed.
  [[nodiscard]] virtual Result<void, StreamFault> transfer(std::uint8_t address, ByteView out, ByteSpan in) = 0;

  /// Waits for a time. False: interrupt() came first.
  [[nodiscard]] virtual bool wait_until(MonotonicTime time) = 0;
  /// Ends a wait_until() at once, or else the next one.
  virtual void interrupt() noexcept = 0;

  /// Opens the same bus again after a fault. Errors: NotFound, NotUsable.
  [[nodiscard]] virtual Result<void, StreamFault> reopen() = 0;
  /// True until reopen() has found a bus that was absent, from the start or since a fault.
  [[nodiscard]] virtual bool is_away() const noexcept { return false; }
};

/// Reads registers from `reg` on.
[[nodiscard]] inline Result<void, StreamFault> read_registers(RegisterBus& bus, std::uint8_t address, std::uint8_t reg,
                                                              ByteSpan in) {
  return bus.transfer(address, {&reg, 1}, in);
}

/// Writes one register.
[[nodiscard]] inline Result<void, StreamFault> write_register(RegisterBus& bus, std::uint8_t address, std::uint8_t reg,
                                                              std::uint8_t value) {
  const std::uint8_t bytes[] = {reg, value};
  return bus.transfer(address, bytes, {});
}

}  // namespace nacelle::io
