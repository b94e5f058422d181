// SPDX-License-Identifier: Apache-2.0
#include "battery/model/battery_model.hpp"

#include <gtest/gtest.h>

namespace nacelle::battery {
namespace {

// 100 uA a count, the widest range.
constexpr Ina219Setup kSetup{.config = 0x3FFF, .calibration = 4096, .amperes_per_count = 1e-4};

Ina219Reading reading_of(double bus_v, double current_a) {
  Ina219Reading reading;
  reading.bus_counts = static_cast<std::uint16_t>(bus_v / 4e-3 + 0.5);
  reading.current_counts = static_cast<std::int16_t>(current_a / 1e-4);
  reading.shunt_counts = static_cast<std::int16_t>(current_a * 0.1 / 1e-5);
  reading.is_converted = true;
  return reading;
}

TEST(BatteryModel, a_discharge_is_negative_and_the_shunts_voltage_belongs_to_the_battery) {
  const auto battery = battery_reading(reading_of(12.0, 1.5), kSetup, {});
  EXPECT_NEAR(*battery.current_a, -1.5, 1e-9);
  EXPECT_NEAR(battery.voltage_v, 12.15, 1e-9);
  EXPECT_EQ(battery.status, BatteryStatus::Discharging);
  EXPECT_TRUE(battery.is_present);
  EXPECT_EQ(battery.percentage, std::nullopt);
}

TEST(BatteryModel, a_charge_is_positive) {
  const auto battery = battery_reading(reading_of(12.0, -1.0), kSetup, {});
  EXPECT_NEAR(*battery.current_a, 1.0, 1e-9);
  EXPECT_NEAR(battery.voltage_v, 11.9, 1e-9);
  EXPECT_EQ(battery.status, BatteryStatus::Charging);
}

TEST(BatteryModel, a_battery_at_the_other_side_has_the_other_sign_and_the_bus_voltage) {
  const auto battery = battery_reading(reading_of(12.0, -1.5), kSetup, {.is_reversed = true});
  EXPECT_NEAR(*battery.current_a, -1.5, 1e-9);
  EXPECT_NEAR(battery.voltage_v, 12.0, 1e-9);
  EXPECT_EQ(battery.status, BatteryStatus::Discharging);
}

TEST(BatteryModel, less_than_half_a_percent_of_the_highest_current_is_none) {
  EXPECT_EQ(battery_reading(reading_of(12.0, 0.015), kSetup, {}).status, BatteryStatus::Idle);
  EXPECT_EQ(battery_reading(reading_of(12.0, 0.017), kSetup, {}).status, BatteryStatus::Discharging);
  EXPECT_EQ(battery_reading(reading_of(12.0, -0.017), kSetup, {}).status, BatteryStatus::Charging);
}

TEST(BatteryModel, a_current_that_overflows_or_is_clipped_is_unknown) {
  Ina219Reading overflown = reading_of(12.0, 1.0);
  overflown.has_overflown = true;
  const auto unknown = battery_reading(overflown, kSetup, {});
  EXPECT_EQ(unknown.current_a, std::nullopt);
  EXPECT_EQ(unknown.status, BatteryStatus::Unknown);
  EXPECT_TRUE(unknown.is_present);

  Ina219Setup narrow = kSetup;
  narrow.config = 0x2FFF;  // 80 mV
  Ina219Reading clipped = reading_of(12.0, 0.0);
  for (const int counts : {7999, -7999}) {
    clipped.shunt_counts = static_cast<std::int16_t>(counts);
    EXPECT_TRUE(battery_reading(clipped, narrow, {}).current_a) << counts;
  }
  for (const int counts : {8000, -8000}) {
    clipped.shunt_counts = static_cast<std::int16_t>(counts);
    EXPECT_FALSE(battery_reading(clipped, narrow, {}).current_a) << counts;
  }
}

TEST(BatteryModel, the_percentage_is_between_the_voltages_of_empty_and_full) {
  const BatterySettings cells{.empty_v = 9.9, .full_v = 12.6};
  EXPECT_NEAR(*battery_reading(reading_of(11.252, 0.0), kSetup, cells).percentage, 0.5, 1e-3);
  EXPECT_EQ(battery_reading(reading_of(13.0, 0.0), kSetup, cells).percentage, 1.0);
  EXPECT_EQ(battery_reading(reading_of(9.0, 0.0), kSetup, cells).percentage, 0.0);
}

TEST(BatteryModel, a_bus_without_a_voltage_has_no_battery_and_no_percentage) {
  const auto battery = battery_reading(reading_of(0.4, 0.0), kSetup, {.empty_v = 9.9, .full_v = 12.6});
  EXPECT_FALSE(battery.is_present);
  EXPECT_EQ(battery.percentage, std::nullopt);
}

}  // namespace
}  // namespace nacelle::battery
