// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle::battery {

/// Registers of an INA219, 16 bits each, the more significant byte first.
/// Source: TI, INA219 data sheet SBOS448, register set.
enum class Ina219Register : std::uint8_t { Config = 0, Shunt = 1, Bus = 2, Power = 3, Current = 4, Calibration = 5 };

inline constexpr std::uint16_t kIna219Reset = 0x8000;      ///< Of Config: all registers get their first values.
inline constexpr std::uint16_t kIna219AsReset = 0x399F;    ///< Config after power-on and after a reset.
inline constexpr std::uint16_t kIna219PowerDown = 0x0000;  ///< Config: nothing is measured.
inline constexpr double kIna219WidestShunt_v = 0.32;       ///< The widest range of the voltage over the shunt.

/// What we write into an INA219, and what its counts mean then.
struct Ina219Setup {
  std::uint16_t config = 0;
  std::uint16_t calibration = 0;
  double amperes_per_count = 0.0;  ///< Of the register Current.
  friend bool operator==(const Ina219Setup&, const Ina219Setup&) = default;
};

/// Returns the setup for a shunt, the highest current and the time between two polls: bus voltages up to 32 V (the chip bears 26), the narrowest
/// range of the shunt's voltage that holds max_current_a, and as many samples in the mean as leave time for both conversions twice in a period.
/// Empty if the highest current gives more than 0.32 V over the shunt. Precondition: all are positive.
/// Source: data sheet, configuration register, and equation 1 of the calibration.
[[nodiscard]] std::optional<Ina219Setup> ina219_setup(double shunt_ohms, double max_current_a, Duration period);

}  // namespace nacelle::battery
