// SPDX-License-Identifier: Apache-2.0
// The I2C port and an IMU behind it on a bus of a real kernel: a module whose chip has registers, fails on request, and can be unplugged.
#include "nacelle/io/i2c_bus.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "imu/component/imu_component.hpp"
#include "regsim.hpp"
#include "support/recording_host.hpp"

namespace nacelle::io {
namespace {

using test::kPatience;
using test::Regsim;

/// The bus is plugged in and without faults, its chip is an MPU-6050 as it is when the power comes.
class RealBus : public ::testing::Test {
 protected:
  void SetUp() override {
    NACELLE_ONLY_IN_MACHINE("i2c");
    path_ = Regsim::path();
    ASSERT_FALSE(path_.empty());
    ASSERT_TRUE(test::wait_for_node(path_, clock_));
    power_up();
  }
  void TearDown() override {
    if (!test::in_machine("i2c")) return;
    Regsim::hold(false);
    Regsim::lose_every(0);
    Regsim::power(true);
    if (Regsim::path().empty()) Regsim::plug();
  }
  static void power_up() {
    std::string registers(256, '\0');
    registers[0x6B] = 0x40;
    registers[0x75] = 0x68;
    Regsim::write(0, registers);
    Regsim::power(true);
  }
  /// Counts of acceleration, temperature and angular velocity in the chip's data registers, big-endian from 3B on.
  static void measure(const std::array<std::int16_t, 7>& counts) {
    std::string bytes;
    for (const int count : counts) {
      bytes += static_cast<char>(count >> 8);
      bytes += static_cast<char>(count);
    }
    Regsim::write(0x3B, bytes);
  }
  std::unique_ptr<I2cBus> open() {
    auto bus = I2cBus::open({path_, Regsim::kAddress}, clock_);
    EXPECT_TRUE(bus) << bus.error().text();
    return bus ? std::move(bus).value() : nullptr;
  }

  SystemClock clock_;
  std::string path_;
};

TEST_F(RealBus, reads_and_writes_registers_in_one_transfer) {
  const auto bus = open();
  ASSERT_TRUE(bus);
  const unsigned before = Regsim::transfers();
  std::array<std::uint8_t, 3> bytes{};
  Regsim::write(0x10, "abc");
  ASSERT_TRUE(read_registers(*bus, Regsim::kAddress, 0x10, bytes));
  EXPECT_THAT(bytes, ::testing::ElementsAre('a', 'b', 'c'));
  ASSERT_TRUE(write_register(*bus, Regsim::kAddress, 0x11, 0x42));
  EXPECT_EQ(Regsim::read(0x11), 0x42);
  EXPECT_EQ(Regsim::transfers() - before, 2U);
}

TEST_F(RealBus, tells_a_chip_that_does_not_answer_from_a_bus_that_is_stuck) {
  const auto bus = open();
  ASSERT_TRUE(bus);
  std::array<std::uint8_t, 1> byte{};
  EXPECT_EQ(read_registers(*bus, Regsim::kAddress + 1, 0x75, byte).error(), StreamFault::NoAnswer);
  Regsim::lose_every(1);
  EXPECT_EQ(read_registers(*bus, Regsim::kAddress, 0x75, byte).error(), StreamFault::NoAnswer);
  Regsim::lose_every(0);
  Regsim::hold(true);
  EXPECT_EQ(read_registers(*bus, Regsim::kAddress, 0x75, byte).error(), StreamFault::BusStuck);
  Regsim::hold(false);
  ASSERT_TRUE(read_registers(*bus, Regsim::kAddress, 0x75, byte));
  EXPECT_EQ(byte[0], 0x68);
}

TEST_F(RealBus, refuses_what_is_no_bus_of_this_kind) {
  EXPECT_EQ(I2cBus::open({"/dev/i2c-99", 0x68}, clock_).error().what, "no such bus");
  EXPECT_EQ(I2cBus::open({"/dev/null", 0x68}, clock_).error().what, "not an I2C bus");
  EXPECT_NE(I2cBus::open({path_, 0x80}, clock_).error().what.find("0x80 is no address"), std::string::npos);
}

// An adapter that a program keeps open is not gone for the kernel: its driver waits, and its number is taken. plug() then fails.
TEST_F(RealBus, lets_an_unplugged_adapter_go_and_finds_it_under_the_same_number) {
  const auto bus = open();
  ASSERT_TRUE(bus);
  std::array<std::uint8_t, 1> byte{};
  Regsim::unplug();
  EXPECT_EQ(read_registers(*bus, Regsim::kAddress, 0x75, byte).error(), StreamFault::HungUp);
  ASSERT_TRUE(test::wait_for_no_node(path_, clock_));
  EXPECT_EQ(bus->reopen().error(), StreamFault::NotFound);
  EXPECT_TRUE(bus->is_away());
  EXPECT_EQ(read_registers(*bus, Regsim::kAddress, 0x75, byte).error(), StreamFault::NotFound);

  Regsim::plug();
  EXPECT_EQ(Regsim::path(), path_);
  ASSERT_TRUE(test::wait_for_node(path_, clock_));
  ASSERT_TRUE(bus->reopen());
  EXPECT_FALSE(bus->is_away());
  ASSERT_TRUE(read_registers(*bus, Regsim::kAddress, 0x75, byte));
  EXPECT_EQ(byte[0], 0x68);
}

/// An MPU-6050 whose data registers are read; its FIFO is for emulators.
class RealImu : public RealBus {
 protected:
  void bring_up() {
    NodeOptions options{context_};
    options.parameter_overrides({{"model", std::string{"mpu6050"}},
                                 {"port", path_},
                                 {"rate", 50.0},
                                 {"use_fifo", false},
                                 {"accel_range", std::int64_t{2}},
                                 {"gyro_range", std::int64_t{250}},
                                 {"calibrate_gyro", false}});
    imu_ = std::make_unique<imu::ImuComponent>(options);
    const auto configured = imu_->trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    const auto activated = imu_->trigger(Transition::Activate);
    ASSERT_TRUE(activated.success) << activated.reason;
  }
  [[nodiscard]] bool wait_for_more(std::size_t count) {
    return context_.wait_for("/imu/data_raw", context_.published<sensor_msgs::msg::Imu>("/imu/data_raw").size() + count,
                             kPatience);
  }
  [[nodiscard]] sensor_msgs::msg::Imu last() {
    return context_.published<sensor_msgs::msg::Imu>("/imu/data_raw").back();
  }

  test::RecordingContext context_{clock_};
  std::unique_ptr<imu::ImuComponent> imu_;
};

constexpr std::array<std::int16_t, 7> kAtRest{0, 0, 16384, 0, 0, 0, 0};

TEST_F(RealImu, is_identified_set_up_and_read) {
  measure({8192, -4096, 16384, 0, 131, -262, 0});
  bring_up();
  EXPECT_EQ(Regsim::read(0x19), 19) << "1 kHz / 50 Hz - 1";
  EXPECT_EQ(Regsim::read(0x6B), 0x01) << "awake";
  ASSERT_TRUE(wait_for_more(3));
  EXPECT_NEAR(last().linear_acceleration.x, 0.5 * 9.80665, 1e-9);
  EXPECT_NEAR(last().linear_acceleration.y, -0.25 * 9.80665, 1e-9);
  EXPECT_NEAR(last().angular_velocity.x, std::numbers::pi / 180.0, 1e-9);
  EXPECT_NEAR(last().angular_velocity.y, -2 * std::numbers::pi / 180.0, 1e-9);
  EXPECT_TRUE(context_.open_faults().empty());
}

TEST_F(RealImu, another_chip_at_its_address_is_refused) {
  Regsim::write(0x75, "\x71");
  NodeOptions options{context_};
  options.parameter_overrides({{"model", std::string{"mpu6050"}}, {"port", path_}});
  imu::ImuComponent imu{options};
  const auto configured = imu.trigger(Transition::Configure);
  ASSERT_FALSE(configured.success);
  EXPECT_NE(configured.reason.find("MPU-6050"), std::string::npos) << configured.reason;
}

TEST_F(RealImu, a_transfer_that_is_not_acknowledged_is_tried_again) {
  measure(kAtRest);
  bring_up();
  Regsim::lose_every(2);
  ASSERT_TRUE(wait_for_more(10));
  EXPECT_TRUE(context_.open_faults().empty());
  EXPECT_EQ(context_.closed_faults(), 0U);
}

TEST_F(RealImu, a_silent_chip_a_stuck_bus_and_a_chip_without_its_settings_are_open_faults_until_they_return) {
  measure(kAtRest);
  bring_up();
  const std::pair<std::function<void()>, std::function<void()>> faults[] = {
      {[] { Regsim::lose_every(1); }, [] { Regsim::lose_every(0); }},
      {[] { Regsim::hold(true); }, [] { Regsim::hold(false); }},
      {[] { Regsim::power(false); },
       [] {
         power_up();
         measure(kAtRest);
       }}};
  for (std::size_t i = 0; i < std::size(faults); ++i) {
    ASSERT_TRUE(wait_for_more(2)) << "fault " << i;
    faults[i].first();
    context_.wait_for_open_faults(1);
    EXPECT_EQ(context_.open_faults().front().code, "DEVICE_LOST");
    faults[i].second();
    context_.wait_for_open_faults(0);
    ASSERT_TRUE(wait_for_more(2)) << "after fault " << i;
    EXPECT_EQ(context_.closed_faults(), i + 1);
    EXPECT_EQ(Regsim::read(0x6B), 0x01) << "set up again after fault " << i;
  }
  EXPECT_TRUE(context_.faults().empty());
}

TEST_F(RealImu, every_unplugging_of_the_bus_is_counted_and_nothing_leaks) {
  measure(kAtRest);
  bring_up();
  ASSERT_TRUE(wait_for_more(1));
  const auto files = test::count_entries("/proc/self/fd"), threads = test::count_entries("/proc/self/task");
  const auto count = static_cast<std::size_t>(test::cycles());
  for (std::size_t cycle = 1; cycle <= count; ++cycle) {
    Regsim::unplug();
    context_.wait_for_open_faults(1);
    EXPECT_EQ(context_.open_faults().front().code, "DEVICE_LOST");
    Regsim::plug();
    ASSERT_EQ(Regsim::path(), path_) << "in cycle " << cycle;
    context_.wait_for_open_faults(0);
    ASSERT_TRUE(wait_for_more(1)) << "in cycle " << cycle;
    EXPECT_EQ(context_.closed_faults(), cycle);
  }
  EXPECT_EQ(test::count_entries("/proc/self/fd"), files);
  EXPECT_EQ(test::count_entries("/proc/self/task"), threads);
  EXPECT_TRUE(context_.faults().empty());
}

}  // namespace
}  // namespace nacelle::io
