// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "battery/protocol/ina219_decoder.hpp"

namespace nacelle::battery {

/// How a battery is wired to its monitor, and what is known of it.
struct BatterySettings {
  bool is_reversed = false;               ///< The battery is at IN-, and the load at IN+.
  double max_current_a = 3.2;             ///< Above it the current counts as unknown.
  std::optional<double> empty_v, full_v;  ///< Between them the charge is estimated; both or none.
};

enum class BatteryStatus : std::uint8_t { Unknown, Charging, Discharging, Idle };

/// What the battery does, in the signs of sensor_msgs/BatteryState.
struct BatteryReading {
  double voltage_v = 0.0;            ///< At the battery's poles.
  std::optional<double> current_a;   ///< Negative while it discharges; empty: above what is measured.
  std::optional<double> percentage;  ///< 0 to 1, by the voltage, which sags under load: a rough estimate.
  BatteryStatus status = BatteryStatus::Unknown;
  bool is_present = false;
};

/// Returns what a reading means. The voltage is measured between IN- and ground, so that of the shunt is added where the battery is at IN+.
[[nodiscard]] BatteryReading battery_reading(const Ina219Reading& reading, const Ina219Setup& setup,
                                             const BatterySettings& battery);

}  // namespace nacelle::battery
