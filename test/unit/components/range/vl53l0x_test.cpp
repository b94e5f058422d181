// SPDX-License-Identifier: Apache-2.0
// The driver against an emulator that shares no code with it.
#include "range/component/vl53l0x.hpp"

#include <gtest/gtest.h>

#include "vl53l0x_rig.hpp"

namespace nacelle::range {
namespace {

class Vl53l0xTest : public ::testing::Test {
 protected:
  Vl53l0xTest() { bus_->allow_until(clock_.now() + 1000s); }
  /// Asks every millisecond; nothing if no result comes in `limit`.
  std::optional<Vl53l0xResult> next_result(Duration limit = 1s) {
    std::array<std::uint8_t, Vl53l0xDecoder::kRecordBytes> record{};
    const MonotonicTime deadline = clock_.now() + limit;
    while (clock_.now() < deadline) {
      const auto is_new = sensor_.read(record);
      if (!is_new) return std::nullopt;
      if (*is_new) return Vl53l0xDecoder::decode(record);
      EXPECT_TRUE(bus_->wait_until(clock_.now() + 1ms));
    }
    return std::nullopt;
  }

  test::ManualClock clock_;
  simulation::Vl53l0xChip chip_;
  std::unique_ptr<io::ScriptedBus> bus_ = make_bus(chip_, clock_);
  Vl53l0x sensor_{*bus_, {.address = 0x29, .period = 100ms, .budget = 33ms}, clock_};
};

TEST_F(Vl53l0xTest, measures_at_its_period_with_its_budget) {
  ASSERT_TRUE(sensor_.set_up());
  EXPECT_NEAR(chip_.measurement_s(), 0.033, 0.0004);
  ASSERT_TRUE(sensor_.start());
  ASSERT_TRUE(next_result());
  const MonotonicTime begin = clock_.now();
  for (int i = 0; i < 10; ++i) {
    chip_.look_at({.distance_mm = static_cast<std::uint16_t>(100 * i + 50)});
    const auto result = next_result();
    ASSERT_TRUE(result) << i;
    EXPECT_EQ(result->status, Vl53l0xStatus::Complete);
    EXPECT_EQ(result->distance_mm, 100 * i + 50);
  }
  EXPECT_NEAR(to_seconds(clock_.now() - begin), 1.0, 0.011);
}

TEST_F(Vl53l0xTest, every_budget_that_may_be_set_is_kept) {
  for (const Duration budget : {20ms, 33ms, 66ms, 200ms, 500ms}) {
    Vl53l0x sensor{*bus_, {.period = budget + 10ms, .budget = budget}, clock_};
    ASSERT_TRUE(sensor.set_up()) << to_seconds(budget);
    EXPECT_NEAR(chip_.measurement_s() / to_seconds(budget), 1.0, 0.01);
  }
}

TEST_F(Vl53l0xTest, switches_on_as_many_reference_cells_as_the_factory_says) {
  for (const auto& [told, first] : {std::pair{0x80 | 5, 12}, std::pair{0x80 | 25, 12}, std::pair{7, 1}}) {
    chip_.set_power(true);
    chip_.set_reference(static_cast<std::uint8_t>(told));
    ASSERT_TRUE(sensor_.set_up());
    EXPECT_EQ(chip_.cells_on(), told & 0x7F) << told;
    EXPECT_EQ(chip_.first_cell(), first) << told;
  }
}

TEST_F(Vl53l0xTest, gives_the_chip_the_makers_values) {
  ASSERT_TRUE(sensor_.set_up());
  // Of the first, a middle and the last block of the list, on both pages.
  EXPECT_EQ(chip_.value_on(0, 0x25), 0xFF);
  EXPECT_EQ(chip_.value_on(1, 0x4E), 0x2C);
  EXPECT_EQ(chip_.value_on(0, 0x66), 0xA0);
  EXPECT_EQ(chip_.value_on(1, 0x45), 0x26);
  EXPECT_EQ(chip_.value_on(1, 0x4D), 0x04);
  EXPECT_EQ(chip_.value_on(0, 0x48), 0x28);
  EXPECT_EQ(chip_.value_on(1, 0x8E), 0x01);
  EXPECT_EQ(chip_.value_on(0, 0x01), 0xE8);
  EXPECT_EQ(chip_.value_on(0, 0xFF), 0x00) << "the page that results are on";
  EXPECT_EQ(chip_.value_on(0, 0x80), 0x00);
}

TEST_F(Vl53l0xTest, stops_and_starts_again) {
  ASSERT_TRUE(sensor_.set_up());
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(sensor_.start());
    EXPECT_TRUE(chip_.measures());
    ASSERT_TRUE(next_result()) << round;
    ASSERT_TRUE(sensor_.stop());
    EXPECT_FALSE(chip_.measures());
    const int measured = chip_.measurements();
    EXPECT_FALSE(next_result()) << "nothing is left over";
    EXPECT_EQ(chip_.measurements(), measured);
  }
}

TEST_F(Vl53l0xTest, a_program_that_ended_without_a_stop_is_no_obstacle) {
  ASSERT_TRUE(sensor_.set_up());
  ASSERT_TRUE(sensor_.start());
  ASSERT_TRUE(next_result());
  ASSERT_TRUE(io::write_register(*bus_, 0x29, 0xFF, 0x01));  // in the midst of something

  Vl53l0x other{*bus_, {}, clock_};
  ASSERT_TRUE(other.set_up());
  EXPECT_FALSE(chip_.measures());
  ASSERT_TRUE(other.start());
  EXPECT_TRUE(next_result());
}

TEST_F(Vl53l0xTest, another_chip_at_its_address_is_refused_for_good) {
  // A VL53L1X has registers of 16 bits: it takes the first byte for half of the address.
  bus_->attach(0x29, [](ByteView, ByteSpan in) {
    std::fill(in.begin(), in.end(), std::uint8_t{0x1D});
    return true;
  });
  const auto done = sensor_.set_up();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().fault, io::StreamFault::NotUsable);
  EXPECT_EQ(done.error().what, "the chip at 0x29 is no VL53L0X (it says 1d1d, not eeaa)");
}

TEST_F(Vl53l0xTest, a_calibration_that_does_not_end_is_named) {
  chip_.break_calibration(true);
  const auto done = sensor_.set_up();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().fault, io::StreamFault::NoAnswer);
  EXPECT_EQ(done.error().what, "it does not finish the calibration of its voltage");
  chip_.break_calibration(false);
  EXPECT_TRUE(sensor_.set_up());
}

TEST_F(Vl53l0xTest, a_slow_and_a_long_measurement_are_stopped) {
  for (const auto& [period, budget] : {std::pair{10s, 33ms}, std::pair{1s, 500ms}}) {
    Vl53l0x sensor{*bus_, {.period = period, .budget = budget}, clock_};
    for (const Duration into : {Duration{10ms}, Duration{100ms}, Duration{600ms}}) {
      ASSERT_TRUE(sensor.set_up());
      ASSERT_TRUE(sensor.start());
      EXPECT_TRUE(bus_->wait_until(clock_.now() + into));
      const auto stopped = sensor.stop();
      EXPECT_TRUE(stopped) << to_seconds(into);
      EXPECT_FALSE(chip_.measures());
    }
  }
}

/// Lets so many transfers through, then none, until it is mended.
struct Cut {
  io::ScriptedBus& bus;
  simulation::Vl53l0xChip& chip;
  void after(std::uint64_t transfers) {
    bus.attach(0x29, [this, left = transfers](ByteView out, ByteSpan in) mutable {
      if (left == 0) return false;
      --left;
      return chip.transfer(out, in);
    });
  }
  void mend() {
    bus.attach(0x29, [this](ByteView out, ByteSpan in) { return chip.transfer(out, in); });
  }
};

// With the chip's registers as the cut left them, and with those of a chip whose power went, too.
TEST_F(Vl53l0xTest, a_set_up_that_is_cut_off_anywhere_can_be_begun_anew) {
  ASSERT_TRUE(sensor_.set_up());
  const std::uint64_t whole = bus_->transfers();
  ASSERT_GT(whole, 100U);
  Cut cut{*bus_, chip_};
  for (const bool loses_power : {false, true}) {
    for (std::uint64_t count = 0; count < whole; ++count) {
      chip_.set_power(true);
      cut.after(count);
      const auto done = sensor_.set_up();
      ASSERT_FALSE(done) << count;
      EXPECT_EQ(done.error().fault, io::StreamFault::NoAnswer) << count;
      if (loses_power) chip_.set_power(true);
      cut.mend();
      ASSERT_TRUE(sensor_.set_up()) << count;
      ASSERT_TRUE(sensor_.start()) << count;
      ASSERT_TRUE(next_result()) << count;
      EXPECT_NEAR(chip_.measurement_s(), 0.033, 0.0004) << count;
    }
  }
}

TEST_F(Vl53l0xTest, a_stop_that_is_cut_off_anywhere_does_not_keep_it_from_measuring_again) {
  ASSERT_TRUE(sensor_.set_up());
  ASSERT_TRUE(sensor_.start());
  const std::uint64_t before = bus_->transfers();
  ASSERT_TRUE(sensor_.stop());
  const std::uint64_t whole = bus_->transfers() - before;
  Cut cut{*bus_, chip_};
  for (std::uint64_t count = 0; count < whole; ++count) {
    ASSERT_TRUE(sensor_.start());
    cut.after(count);
    ASSERT_FALSE(sensor_.stop()) << count;
    cut.mend();
    ASSERT_TRUE(sensor_.set_up()) << count;
    ASSERT_TRUE(sensor_.start()) << count;
    ASSERT_TRUE(next_result()) << count;
    ASSERT_TRUE(sensor_.stop()) << count;
  }
}

TEST_F(Vl53l0xTest, a_transfer_that_is_not_acknowledged_is_tried_again) {
  ASSERT_TRUE(sensor_.set_up());
  ASSERT_TRUE(sensor_.start());
  bus_->lose_every(2);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(next_result());
  EXPECT_GT(sensor_.retries(), 5U);
  bus_->lose_every(1);
  EXPECT_FALSE(next_result());
}

}  // namespace
}  // namespace nacelle::range
