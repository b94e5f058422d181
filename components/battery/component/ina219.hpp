// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "battery/protocol/ina219_decoder.hpp"
#include "battery/protocol/ina219_setup.hpp"
#include "nacelle/io/register_stream.hpp"

namespace nacelle::battery {

/// Why an INA219 cannot be used, in words. `fault` is NotUsable if no wait mends that.
struct Ina219Problem {
  io::StreamFault fault = io::StreamFault::NoAnswer;
  std::string what, way_out;
};

/// An INA219 on a bus: what is written to it. Its registers are read by a RegisterStream with ina219_blocks().
/// Threads: one. Allocates: nothing, but for the words of a problem.
class Ina219 {
 public:
  Ina219(io::RegisterBus& bus, std::uint8_t address, const Ina219Setup& setup)
      : bus_(bus), address_(address), setup_(setup) {}

  /// Resets the chip, and gives it its settings: it measures from then on. The chip has no name in a register; what its configuration is after
  /// a reset must do.
  [[nodiscard]] Result<void, Ina219Problem> set_up();
  /// Ends measuring: the chip takes some 10 uA then.
  [[nodiscard]] Result<void, io::StreamFault> power_down();

 private:
  [[nodiscard]] Result<void, io::StreamFault> write(Ina219Register reg, std::uint16_t value);
  [[nodiscard]] Result<std::uint16_t, io::StreamFault> read(Ina219Register reg);

  io::RegisterBus& bus_;
  const std::uint8_t address_;
  const Ina219Setup setup_;
};

/// What is read at each poll, in the order that Ina219Decoder takes.
[[nodiscard]] std::vector<io::PollBlock> ina219_blocks(std::uint8_t address);

}  // namespace nacelle::battery
