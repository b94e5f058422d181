// SPDX-License-Identifier: Apache-2.0
#include "range/component/vl53l0x_wire.hpp"

#include <algorithm>
#include <array>

#include "nacelle/base/expect.hpp"

namespace nacelle::range {

Vl53l0xWire& Vl53l0xWire::write(std::uint8_t reg, std::uint8_t value) {
  if (!fault_) note(io::write_register(bus_, address_, reg, value));
  return *this;
}

Vl53l0xWire& Vl53l0xWire::write(std::span<const RegisterWrite> all) {
  for (const auto& one : all) write(one.reg, one.value);
  return *this;
}

Vl53l0xWire& Vl53l0xWire::write_16(std::uint8_t reg, std::uint16_t value) {
  const std::uint8_t bytes[] = {static_cast<std::uint8_t>(value >> 8U), static_cast<std::uint8_t>(value)};
  return write_bytes(reg, bytes);
}

Vl53l0xWire& Vl53l0xWire::write_32(std::uint8_t reg, std::uint32_t value) {
  const std::uint8_t bytes[] = {static_cast<std::uint8_t>(value >> 24U), static_cast<std::uint8_t>(value >> 16U),
                                static_cast<std::uint8_t>(value >> 8U), static_cast<std::uint8_t>(value)};
  return write_bytes(reg, bytes);
}

Vl53l0xWire& Vl53l0xWire::write_bytes(std::uint8_t reg, ByteView bytes) {
  std::array<std::uint8_t, 9> out{reg};
  NACELLE_EXPECT(bytes.size() < out.size(), "a VL53L0X takes a few bytes at once");
  std::copy(bytes.begin(), bytes.end(), out.begin() + 1);
  if (!fault_) note(bus_.transfer(address_, ByteView{out}.first(bytes.size() + 1), {}));
  return *this;
}

std::uint8_t Vl53l0xWire::read(std::uint8_t reg) {
  std::array<std::uint8_t, 1> byte{};
  read_bytes(reg, byte);
  return byte[0];
}

std::uint16_t Vl53l0xWire::read_16(std::uint8_t reg) {
  std::array<std::uint8_t, 2> bytes{};
  read_bytes(reg, bytes);
  return static_cast<std::uint16_t>(unsigned{bytes[0]} << 8U | bytes[1]);
}

void Vl53l0xWire::read_bytes(std::uint8_t reg, ByteSpan bytes) {
  if (!fault_) note(io::read_registers(bus_, address_, reg, bytes));
  if (fault_) std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
}

bool Vl53l0xWire::wait_for(std::uint8_t reg, std::uint8_t mask, bool set, Duration limit) {
  const MonotonicTime deadline = clock_.now() + limit;
  for (;;) {
    const bool is_set = (read(reg) & mask) != 0;
    if (fault_) return false;
    if (is_set == set) return true;
    const MonotonicTime now = clock_.now();
    if (now >= deadline) return false;
    // An interrupt is for the thread that reads, which asks again whether it is to end: a device is not left half set up or half stopped.
    static_cast<void>(bus_.wait_until(now + 1ms));
  }
}

}  // namespace nacelle::range
