// SPDX-License-Identifier: Apache-2.0
#include "battery/component/ina219.hpp"

#include <fmt/format.h>

#include <array>

namespace nacelle::battery {
namespace {

Ina219Problem problem_of(io::StreamFault fault) {
  return {fault, std::string(io::explain(fault)), "is it wired, and has it this address (its pins A0 and A1)?"};
}

}  // namespace

Result<void, io::StreamFault> Ina219::write(Ina219Register reg, std::uint16_t value) {
  const std::array bytes{static_cast<std::uint8_t>(reg), static_cast<std::uint8_t>(value >> 8U),
                         static_cast<std::uint8_t>(value)};
  return bus_.transfer(address_, bytes, {});
}

Result<std::uint16_t, io::StreamFault> Ina219::read(Ina219Register reg) {
  std::array<std::uint8_t, 2> bytes{};
  if (auto done = io::read_registers(bus_, address_, static_cast<std::uint8_t>(reg), bytes); !done)
    return err(done.error());
  return static_cast<std::uint16_t>(bytes[0] << 8 | bytes[1]);
}

Result<void, Ina219Problem> Ina219::set_up() {
  if (const auto done = write(Ina219Register::Config, kIna219Reset); !done) return err(problem_of(done.error()));
  const auto config = read(Ina219Register::Config);
  if (!config) return err(problem_of(config.error()));
  if (*config != kIna219AsReset) {
    return err(Ina219Problem{
        io::StreamFault::NotUsable,
        fmt::format("the chip at 0x{:02x} is no INA219 (after a reset its configuration is {:04x}, not 399f)", address_,
                    *config),
        "is it an INA226, INA260 or another chip? give the INA219's address"});
  }
  if (const auto done = write(Ina219Register::Calibration, setup_.calibration); !done)
    return err(problem_of(done.error()));
  if (const auto done = write(Ina219Register::Config, setup_.config); !done) return err(problem_of(done.error()));
  return {};
}

Result<void, io::StreamFault> Ina219::power_down() { return write(Ina219Register::Config, kIna219PowerDown); }

std::vector<io::PollBlock> ina219_blocks(std::uint8_t address) {
  std::vector<io::PollBlock> blocks;
  for (const Ina219Register reg : Ina219Decoder::kOrder) {
    const auto number = static_cast<std::uint8_t>(reg);
    blocks.push_back({.tag = number, .address = address, .reg = number, .length = 2});
  }
  return blocks;
}

}  // namespace nacelle::battery
