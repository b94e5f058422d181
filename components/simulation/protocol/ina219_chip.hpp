// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "nacelle/base/bytes.hpp"

namespace nacelle::simulation {

/// INA219: a monitor of voltage and current, with six registers of 16 bits. Its pointer stays where it is, unlike a RegisterChip's.
///
/// A conversion takes as long as the configuration says; its results appear at its end, and the register Power takes the mark of that away.
/// Written from the data sheet, apart from the driver.
/// Source: TI, INA219 data sheet SBOS448: register details, table of ADC settings, equations 1 to 5.
class Ina219Chip final {
 public:
  Ina219Chip() { reset(); }
  /// Returns whether the chip acknowledges.
  bool transfer(ByteView out, ByteSpan in);
  void advance(double dt_s);
  /// What its pins have: IN- to ground, and IN+ to IN-.
  void feel(double bus_v, double shunt_v) {
    bus_v_ = bus_v;
    shunt_v_ = shunt_v;
  }
  /// Takes the power away, or gives it back: all registers then have their first values.
  void set_power(bool on) {
    has_power_ = on;
    if (on) reset();
  }
  [[nodiscard]] std::uint16_t value(std::uint8_t reg) const { return registers_[reg]; }
  [[nodiscard]] bool measures() const { return (registers_[0] & 7U) > 4; }
  /// Of shunt and bus together, by the configuration.
  [[nodiscard]] double conversion_s() const;
  [[nodiscard]] std::uint64_t conversions() const { return conversions_; }

 private:
  void reset();
  void write(std::uint8_t reg, std::uint16_t value);
  void convert();

  std::array<std::uint16_t, 6> registers_{};
  std::uint8_t pointer_ = 0;
  bool has_power_ = true;
  double bus_v_ = 12.0, shunt_v_ = 0.0;
  double left_s_ = 0.0;  // of the conversion under way
  std::uint64_t conversions_ = 0;
};

}  // namespace nacelle::simulation
