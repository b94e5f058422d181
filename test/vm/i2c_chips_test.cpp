// SPDX-License-Identifier: Apache-2.0
// Drivers of chips on I2C through a bus of a real kernel, behind which are the emulators of the simulation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "imu/component/imu_component.hpp"
#include "range/component/vl53l0x_component.hpp"
#include "regsim.hpp"
#include "regsim_chips.hpp"
#include "simulation/protocol/invensense_chips.hpp"
#include "simulation/protocol/vl53l0x_chip.hpp"
#include "support/recording_host.hpp"

namespace nacelle {
namespace {

using sensor_msgs::msg::Range;
using test::kPatience;
using test::Regsim;

class ChipsOnRealBus : public ::testing::Test {
 protected:
  void SetUp() override {
    NACELLE_ONLY_IN_MACHINE("i2c");
    path_ = Regsim::path();
    ASSERT_FALSE(path_.empty());
    ASSERT_TRUE(test::wait_for_node(path_, clock_));
  }
  void TearDown() override {
    if (test::in_machine("i2c") && Regsim::path().empty()) Regsim::plug();
  }
  void bring_up(LifecycleNode& node) {
    const auto configured = node.trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    const auto activated = node.trigger(Transition::Activate);
    ASSERT_TRUE(activated.success) << activated.reason;
  }
  template <typename Message>
  [[nodiscard]] bool wait_for_more(const std::string& topic, std::size_t count) {
    return context_.wait_for(topic, context_.published<Message>(topic).size() + count, kPatience);
  }

  SystemClock clock_;
  std::string path_;
  test::RecordingContext context_{clock_};
};

TEST_F(ChipsOnRealBus, an_mpu6050_is_read_by_its_fifo) {
  simulation::MpuChip chip{false};
  chip.set_power(true);
  test::RegsimChips chips{{{0x68, &chip}}, clock_};
  chips.feel({.acceleration_g = {0.1, -0.2, 0.97}, .rate_dps = {10.0, -20.0, 30.0}, .temperature_c = 31.0});
  NodeOptions options{context_};
  options.parameter_overrides(
      {{"model", std::string{"mpu6050"}}, {"port", path_}, {"rate", 50.0}, {"calibrate_gyro", false}});
  imu::ImuComponent imu{options};
  ASSERT_NO_FATAL_FAILURE(bring_up(imu));
  ASSERT_TRUE(wait_for_more<sensor_msgs::msg::Imu>("/imu/data_raw", 20));
  const auto last = context_.published<sensor_msgs::msg::Imu>("/imu/data_raw").back();
  EXPECT_NEAR(last.linear_acceleration.x, 0.1 * 9.80665, 0.01);
  EXPECT_NEAR(last.linear_acceleration.z, 0.97 * 9.80665, 0.01);
  EXPECT_NEAR(last.angular_velocity.y, -20 * std::numbers::pi / 180, 0.01);
  EXPECT_TRUE(context_.open_faults().empty());
}

TEST_F(ChipsOnRealBus, an_icm20948_and_its_compass_are_two_chips_of_one_bus) {
  simulation::Icm20948Chip chip;
  simulation::CompassChip compass{true};
  test::RegsimChips chips{{{0x68, &chip}, {0x0C, &compass}}, clock_};
  chips.feel({.field_ut = {20.0, 5.0, -43.0}});
  NodeOptions options{context_};
  options.parameter_overrides(
      {{"model", std::string{"icm20948"}}, {"port", path_}, {"rate", 50.0}, {"calibrate_gyro", false}});
  imu::ImuComponent imu{options};
  ASSERT_NO_FATAL_FAILURE(bring_up(imu));
  ASSERT_TRUE(wait_for_more<sensor_msgs::msg::MagneticField>("/imu/mag", 10));
  const auto last = context_.published<sensor_msgs::msg::MagneticField>("/imu/mag").back();
  EXPECT_NEAR(last.magnetic_field.x, 20e-6, 0.2e-6);
  EXPECT_NEAR(last.magnetic_field.z, -43e-6, 0.2e-6);
}

class RealBusVl53l0x : public ChipsOnRealBus {
 protected:
  void start() {
    chips_.emplace(test::RegsimChips::Chips{{0x29, &chip_}}, clock_);
    NodeOptions options{context_};
    options.parameter_overrides({{"port", path_}, {"rate", 20.0}, {"timing_budget", 0.02}});
    range_ = std::make_unique<range::Vl53l0xComponent>(options);
    ASSERT_NO_FATAL_FAILURE(bring_up(*range_));
    ASSERT_TRUE(wait_for_more<Range>("/range", 3));
  }
  void TearDown() override {
    range_.reset();
    chips_.reset();
    ChipsOnRealBus::TearDown();
  }
  simulation::Vl53l0xChip chip_;
  std::optional<test::RegsimChips> chips_;
  std::unique_ptr<range::Vl53l0xComponent> range_;
};

TEST_F(RealBusVl53l0x, is_set_up_measures_and_stops) {
  chip_.look_at({.distance_mm = 1234});
  ASSERT_NO_FATAL_FAILURE(start());
  EXPECT_FLOAT_EQ(context_.published<Range>("/range").back().range, 1.234F);
  ASSERT_TRUE(range_->trigger(Transition::Deactivate).success);
  chips_->between_transfers([&] { EXPECT_FALSE(chip_.measures()); });
  EXPECT_TRUE(context_.open_faults().empty());
}

TEST_F(RealBusVl53l0x, a_loss_of_power_is_an_open_fault_until_it_measures_again) {
  ASSERT_NO_FATAL_FAILURE(start());
  chips_->between_transfers([&] { chip_.set_power(false); });
  context_.wait_for_open_faults(1);
  EXPECT_EQ(context_.open_faults().front().code, "DEVICE_LOST");
  chips_->between_transfers([&] { chip_.set_power(true); });
  context_.wait_for_open_faults(0);
  ASSERT_TRUE(wait_for_more<Range>("/range", 2));
}

// A few cycles only: a set-up is 300 transfers. The long run is the IMU's.
TEST_F(RealBusVl53l0x, is_set_up_again_on_a_bus_that_was_unplugged_and_nothing_leaks) {
  ASSERT_NO_FATAL_FAILURE(start());
  const auto files = test::count_entries("/proc/self/fd"), threads = test::count_entries("/proc/self/task");
  for (std::size_t cycle = 1; cycle <= 3; ++cycle) {
    Regsim::unplug();
    context_.wait_for_open_faults(1);
    Regsim::plug();
    ASSERT_EQ(Regsim::path(), path_) << "in cycle " << cycle;
    context_.wait_for_open_faults(0);
    ASSERT_TRUE(wait_for_more<Range>("/range", 1)) << "in cycle " << cycle;
    EXPECT_EQ(context_.closed_faults(), cycle);
  }
  EXPECT_EQ(test::count_entries("/proc/self/fd"), files);
  EXPECT_EQ(test::count_entries("/proc/self/task"), threads);
  EXPECT_TRUE(context_.faults().empty());
}

}  // namespace
}  // namespace nacelle
