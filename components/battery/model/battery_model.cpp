// SPDX-License-Identifier: Apache-2.0
#include "battery/model/battery_model.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::battery {
namespace {

constexpr double kNoBattery_v = 1.0;  // a bus below that floats, or has a dead cell
constexpr double kIdlePart = 0.005;   // of the highest current: less is neither charge nor discharge

/// The shunt's voltage is at the end of its range: there may be any more.
bool is_clipped(const Ina219Reading& reading, const Ina219Setup& setup) {
  const int range = 4000 << ((setup.config >> 11U) & 3U);
  return std::abs(static_cast<int>(reading.shunt_counts)) >= range;
}

}  // namespace

BatteryReading battery_reading(const Ina219Reading& reading, const Ina219Setup& setup, const BatterySettings& battery) {
  BatteryReading result;
  result.voltage_v = reading.bus_v() + (battery.is_reversed ? 0.0 : reading.shunt_v());
  result.is_present = result.voltage_v >= kNoBattery_v;
  if (!reading.has_overflown && !is_clipped(reading, setup)) {
    const double from_plus_a = reading.current_counts * setup.amperes_per_count;
    result.current_a = battery.is_reversed ? from_plus_a : -from_plus_a;
    const double idle_a = kIdlePart * battery.max_current_a;
    result.status = *result.current_a > idle_a    ? BatteryStatus::Charging
                    : *result.current_a < -idle_a ? BatteryStatus::Discharging
                                                  : BatteryStatus::Idle;
  }
  if (battery.empty_v && battery.full_v && result.is_present) {
    result.percentage =
        std::clamp((result.voltage_v - *battery.empty_v) / (*battery.full_v - *battery.empty_v), 0.0, 1.0);
  }
  return result;
}

}  // namespace nacelle::battery
