// SPDX-License-Identifier: Apache-2.0
// The driver against an emulator that shares no code with it.
#include "battery/component/ina219.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "battery/model/battery_model.hpp"
#include "ina219_rig.hpp"

namespace nacelle::battery {
namespace {

class Ina219Test : public ::testing::Test {
 protected:
  /// Sets up a chip of this setup and reads it once, half a second later.
  BatteryReading read(const Ina219Setup& setup, const BatterySettings& battery) {
    auto bus = make_bus(chip_, clock_);
    bus->allow_until(clock_.now() + 10s);
    Ina219 chip{*bus, 0x40, setup};
    EXPECT_TRUE(chip.set_up());
    io::RegisterStream stream{std::move(bus), ina219_blocks(0x40), 500ms, clock_};
    const auto bytes = stream.read_until(clock_.now() + 1s);
    EXPECT_TRUE(bytes);
    std::optional<BatteryReading> result;
    Ina219Decoder decoder;
    decoder.feed(*bytes, [&](const Ina219Reading& reading) {
      EXPECT_TRUE(reading.is_converted);
      result = battery_reading(reading, setup, battery);
    });
    EXPECT_TRUE(result);
    return result.value_or(BatteryReading{});
  }

  test::ManualClock clock_;
  simulation::Ina219Chip chip_;
  const Ina219Setup setup_ = *ina219_setup(0.1, 3.2, 1s);
};

TEST_F(Ina219Test, measures_what_the_chip_feels_with_every_shunt_and_range) {
  for (const double shunt_ohms : {0.1, 0.01, 0.0005}) {
    for (const double part : {0.02, 0.3, 0.99, -0.5}) {
      for (const double highest_v : {0.04, 0.08, 0.16, 0.32}) {
        const double max_a = highest_v / shunt_ohms;
        const double current_a = part * max_a;
        chip_.feel(11.1, current_a * shunt_ohms);
        const auto battery = read(*ina219_setup(shunt_ohms, max_a, 1s), {.max_current_a = max_a});
        ASSERT_TRUE(battery.current_a) << shunt_ohms << " " << part;
        // A count of the shunt, and one of the current.
        EXPECT_NEAR(*battery.current_a, -current_a, 0.5e-5 / shunt_ohms + 2.0 * max_a / 32768)
            << shunt_ohms << " " << part << " " << highest_v;
        EXPECT_NEAR(battery.voltage_v, 11.1 + current_a * shunt_ohms, 2.1e-3);
      }
    }
  }
}

TEST_F(Ina219Test, the_chip_converts_as_often_as_the_setup_promises) {
  for (const Duration period : {Duration{1s}, Duration{100ms}, Duration{20ms}, Duration{10ms}}) {
    const auto setup = *ina219_setup(0.1, 3.2, period);
    read(setup, {});
    EXPECT_LE(2 * chip_.conversion_s(), to_seconds(period) * 1.001) << to_seconds(period);
    EXPECT_GT(4 * chip_.conversion_s(), std::min(0.27, to_seconds(period)) * 0.99) << to_seconds(period);
  }
}

TEST_F(Ina219Test, a_current_above_the_highest_is_unknown_and_not_wrong) {
  chip_.feel(12.0, 0.06);
  // 0.5 A: 50 mV, in the range of 80 mV. 60 mV is within that range, but overflows the register of the current.
  EXPECT_EQ(read(*ina219_setup(0.1, 0.5, 1s), {.max_current_a = 0.5}).current_a, std::nullopt);
  chip_.feel(12.0, 0.5);
  EXPECT_EQ(read(setup_, {}).current_a, std::nullopt) << "clipped at 320 mV";
  chip_.feel(12.0, -0.5);
  EXPECT_EQ(read(setup_, {}).current_a, std::nullopt);
}

TEST_F(Ina219Test, is_powered_down_and_set_up_again) {
  auto bus = make_bus(chip_, clock_);
  Ina219 chip{*bus, 0x40, setup_};
  ASSERT_TRUE(chip.set_up());
  EXPECT_TRUE(chip_.measures());
  ASSERT_TRUE(chip.power_down());
  EXPECT_FALSE(chip_.measures());
  ASSERT_TRUE(chip.set_up());
  EXPECT_EQ(chip_.value(0), setup_.config);
  EXPECT_EQ(chip_.value(5), setup_.calibration);
}

TEST_F(Ina219Test, a_set_up_that_is_cut_off_anywhere_fails_and_can_be_begun_anew) {
  auto bus = make_bus(chip_, clock_);
  Ina219 chip{*bus, 0x40, setup_};
  ASSERT_TRUE(chip.set_up());
  const std::uint64_t whole = bus->transfers();
  for (std::uint64_t count = 0; count < whole; ++count) {
    chip_.set_power(true);
    bus->attach(0x40, [this, left = count](ByteView out, ByteSpan in) mutable {
      if (left == 0) return false;
      --left;
      return chip_.transfer(out, in);
    });
    const auto done = chip.set_up();
    ASSERT_FALSE(done) << count;
    EXPECT_EQ(done.error().fault, io::StreamFault::NoAnswer);
    bus->attach(0x40, [this](ByteView out, ByteSpan in) { return chip_.transfer(out, in); });
    ASSERT_TRUE(chip.set_up());
    EXPECT_EQ(chip_.value(0), setup_.config);
  }
}

TEST_F(Ina219Test, another_chip_at_its_address_is_refused_for_good) {
  auto bus = make_bus(chip_, clock_);
  // What an INA226 has in its configuration after a reset.
  bus->attach(0x40, [](ByteView, ByteSpan in) {
    const std::uint8_t bytes[] = {0x41, 0x27};
    std::copy_n(std::begin(bytes), std::min<std::size_t>(in.size(), 2), in.begin());
    return true;
  });
  const auto done = Ina219{*bus, 0x40, setup_}.set_up();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().fault, io::StreamFault::NotUsable);
  EXPECT_EQ(done.error().what, "the chip at 0x40 is no INA219 (after a reset its configuration is 4127, not 399f)");
}

}  // namespace
}  // namespace nacelle::battery
