// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "nacelle/io/register_bus.hpp"

namespace nacelle::range {

/// A value for a register.
struct RegisterWrite {
  std::uint8_t reg, value;
};

/// Registers of a device, one after the other: after a fault nothing more is written, and reads give 0.
class Vl53l0xWire {
 public:
  Vl53l0xWire(io::RegisterBus& bus, std::uint8_t address, const Clock& clock)
      : bus_(bus), address_(address), clock_(clock) {}

  Vl53l0xWire& write(std::uint8_t reg, std::uint8_t value);
  Vl53l0xWire& write(std::span<const RegisterWrite> all);
  /// Big-endian.
  Vl53l0xWire& write_16(std::uint8_t reg, std::uint16_t value);
  Vl53l0xWire& write_32(std::uint8_t reg, std::uint32_t value);
  Vl53l0xWire& write_bytes(std::uint8_t reg, ByteView bytes);
  [[nodiscard]] std::uint8_t read(std::uint8_t reg);
  [[nodiscard]] std::uint16_t read_16(std::uint8_t reg);
  void read_bytes(std::uint8_t reg, ByteSpan bytes);
  /// Waits until some bit of the mask is set (or none, if `set` is false), for `limit` at the most, also if
  /// the bus is interrupted. False: it did not come to that.
  [[nodiscard]] bool wait_for(std::uint8_t reg, std::uint8_t mask, bool set, Duration limit);

  [[nodiscard]] const std::optional<io::StreamFault>& fault() const { return fault_; }

 private:
  void note(const Result<void, io::StreamFault>& done) {
    if (!done) fault_ = done.error();
  }
  io::RegisterBus& bus_;
  const std::uint8_t address_;
  const Clock& clock_;
  std::optional<io::StreamFault> fault_{};
};

}  // namespace nacelle::range
