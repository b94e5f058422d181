// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle::range {

/// How long the steps of a measurement take, as the registers of a VL53L0X say it.
struct Vl53l0xSteps {
  std::uint8_t signal_check = 0;         ///< Register 46: periods less one, of the check before the first measurement.
  std::uint8_t first_laser_period = 0;   ///< Register 50.
  std::uint16_t first_timeout = 0;       ///< Registers 51, 52.
  std::uint8_t second_laser_period = 0;  ///< Register 70.
};

/// A number of periods as two bytes: (low << high) + 1. Zero is not representable and becomes 0000.
[[nodiscard]] std::uint16_t encode_periods(std::uint32_t periods);
[[nodiscard]] std::uint32_t decode_periods(std::uint16_t encoded);
/// What a step counts in, for the value of a register that holds a laser period.
[[nodiscard]] Duration macro_period(std::uint8_t laser_period);

/// The value of the registers 71, 72 (second measurement) with which a whole measurement takes `budget`; nothing if that is too short for the
/// steps before it. The steps are those of register 01 = E8: selection of cells, first and second measurement.
/// Source: ST, VL53L0X API, VL53L0X_set_measurement_timing_budget_micro_seconds and what it calls, with its overheads.
[[nodiscard]] std::optional<std::uint16_t> second_timeout(Duration budget, const Vl53l0xSteps& steps);

}  // namespace nacelle::range
