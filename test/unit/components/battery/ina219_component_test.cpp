// SPDX-License-Identifier: Apache-2.0
#include "battery/component/ina219_component.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ina219_rig.hpp"
#include "support/allocation_guard.hpp"
#include "support/recording_host.hpp"

namespace nacelle::battery {
namespace {

using sensor_msgs::msg::BatteryState;

class Ina219ComponentTest : public ::testing::Test {
 protected:
  // The reading thread ends before the chip.
  void TearDown() override { component_.reset(); }
  Ina219Component& make(std::map<std::string, ParameterValue> overrides = {}) {
    NodeOptions options{context_};
    options.parameter_overrides(std::move(overrides));
    component_ = std::make_unique<Ina219Component>(options, [this](const Ina219Options&, const Clock&) {
      auto bus = make_bus(chip_, context_.clock());
      bus_ = bus.get();
      return Result<std::unique_ptr<io::RegisterBus>, Problem>{std::move(bus)};
    });
    return *component_;
  }
  void bring_up(Ina219Component& battery) {
    const auto configured = battery.trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    ASSERT_TRUE(battery.trigger(Transition::Activate).success);
    until_ = context_.clock().now();
  }
  void run(Duration by) {
    until_ += by;
    bus_->run_until(until_);
  }
  void allow_long() { bus_->allow_until(std::max(until_, context_.clock().now()) + 10'000s); }
  bool measures() {
    bool measures = false;
    bus_->between_transfers([&] { measures = chip_.measures(); });
    return measures;
  }
  std::vector<BatteryState> all() { return context_.published<BatteryState>("/battery_state"); }

  test::RecordingContext context_;
  simulation::Ina219Chip chip_;
  io::ScriptedBus* bus_ = nullptr;
  MonotonicTime until_{};
  std::unique_ptr<Ina219Component> component_;
};

TEST_F(Ina219ComponentTest, publishes_the_battery_with_every_field_set_at_its_rate) {
  chip_.feel(11.1, 0.15);
  Ina219Component& battery = make({{"rate", 2.0},
                                   {"design_capacity", 5.2},
                                   {"power_supply_technology", std::string{"lion"}},
                                   {"empty_voltage", 9.0},
                                   {"full_voltage", 12.6},
                                   {"location", std::string{"front"}}});
  ASSERT_NO_FATAL_FAILURE(bring_up(battery));
  run(10s);
  const auto messages = all();
  EXPECT_NEAR(static_cast<double>(messages.size()), 20.0, 1.0);
  const BatteryState& last = messages.back();
  EXPECT_NEAR(last.voltage, 11.25, 2.1e-3);
  EXPECT_NEAR(last.current, -1.5, 3e-4) << "it discharges";
  EXPECT_NEAR(last.percentage, (11.25 - 9.0) / 3.6, 1e-3);
  EXPECT_FLOAT_EQ(last.design_capacity, 5.2F);
  EXPECT_TRUE(std::isnan(last.temperature));
  EXPECT_TRUE(std::isnan(last.charge));
  EXPECT_TRUE(std::isnan(last.capacity));
  EXPECT_EQ(last.power_supply_status, BatteryState::POWER_SUPPLY_STATUS_DISCHARGING);
  EXPECT_EQ(last.power_supply_health, BatteryState::POWER_SUPPLY_HEALTH_UNKNOWN);
  EXPECT_EQ(last.power_supply_technology, BatteryState::POWER_SUPPLY_TECHNOLOGY_LION);
  EXPECT_TRUE(last.present);
  EXPECT_TRUE(last.cell_voltage.empty());
  EXPECT_EQ(last.location, "front");
  EXPECT_TRUE(context_.open_faults().empty());
  for (std::size_t i = 1; i < messages.size(); ++i)
    EXPECT_NEAR(to_seconds(time_of(messages[i].header.stamp) - time_of(messages[i - 1].header.stamp)), 0.5, 1e-9);
}

TEST_F(Ina219ComponentTest, what_is_not_known_is_not_a_number) {
  chip_.feel(11.1, 0.5);
  Ina219Component& battery = make();
  ASSERT_NO_FATAL_FAILURE(bring_up(battery));
  run(3s);
  ASSERT_FALSE(all().empty());
  EXPECT_TRUE(std::isnan(all().back().current)) << "above 3.2 A";
  EXPECT_EQ(all().back().power_supply_status, BatteryState::POWER_SUPPLY_STATUS_UNKNOWN);
  EXPECT_TRUE(std::isnan(all().back().percentage));
  EXPECT_TRUE(std::isnan(all().back().design_capacity));
  bus_->between_transfers([&] { chip_.feel(11.1, -0.1); });
  run(3s);
  EXPECT_NEAR(all().back().current, 1.0, 3e-4);
  EXPECT_EQ(all().back().power_supply_status, BatteryState::POWER_SUPPLY_STATUS_CHARGING);
}

TEST_F(Ina219ComponentTest, only_an_active_node_measures) {
  Ina219Component& battery = make();
  ASSERT_TRUE(battery.trigger(Transition::Configure).success);
  EXPECT_FALSE(measures());
  for (int round = 0; round < 2; ++round) {
    ASSERT_TRUE(battery.trigger(Transition::Activate).success);
    EXPECT_TRUE(measures()) << round;
    ASSERT_TRUE(battery.trigger(Transition::Deactivate).success);
    EXPECT_FALSE(measures()) << round;
  }
  ASSERT_TRUE(battery.trigger(Transition::Activate).success);
  ASSERT_TRUE(battery.trigger(Transition::Shutdown).success);
  EXPECT_FALSE(chip_.measures()) << "powered down before the bus is closed";
}

TEST_F(Ina219ComponentTest, a_chip_that_lost_its_power_is_an_open_fault_until_it_is_back_and_set_up_again) {
  chip_.feel(12.0, 0.1);
  Ina219Component& battery = make({{"rate", 10.0}});
  ASSERT_NO_FATAL_FAILURE(bring_up(battery));
  run(1s);
  ASSERT_FALSE(all().empty());
  bus_->between_transfers([&] { chip_.set_power(false); });
  allow_long();
  context_.wait_for_open_faults(1);
  EXPECT_EQ(context_.open_faults()[0].code, kDeviceLost);
  EXPECT_NE(context_.open_faults()[0].text.find("INA219 at 0x40 of /dev/i2c-1"), std::string::npos);
  bus_->between_transfers([&] { chip_.set_power(true); });
  context_.wait_for_open_faults(0);
  const std::size_t before = all().size();
  ASSERT_TRUE(context_.wait_for("/battery_state", before + 2));
  EXPECT_NEAR(all().back().current, -1.0, 3e-4) << "calibrated again";
  EXPECT_EQ(battery.get_current_state().state(), StateId::Active);
}

TEST_F(Ina219ComponentTest, a_short_loss_of_power_behind_a_bus_that_works_is_set_up_again_and_no_wrong_current_leaves) {
  chip_.feel(12.0, 0.1);
  Ina219Component& battery = make({{"rate", 10.0}});
  ASSERT_NO_FATAL_FAILURE(bring_up(battery));
  run(1s);
  ASSERT_FALSE(all().empty());
  bus_->between_transfers([&] { chip_.set_power(true); });  // between two polls: no transfer fails
  const std::size_t before = all().size();
  allow_long();
  ASSERT_TRUE(context_.wait_for("/battery_state", before + 5));
  for (const BatteryState& message : all()) EXPECT_NEAR(message.current, -1.0, 3e-4);
}

TEST_F(Ina219ComponentTest, a_stuck_bus_is_an_open_fault_until_it_is_free) {
  Ina219Component& battery = make({{"rate", 10.0}});
  ASSERT_NO_FATAL_FAILURE(bring_up(battery));
  run(1s);
  bus_->fail(io::StreamFault::BusStuck);
  allow_long();
  context_.wait_for_open_faults(1);
  bus_->fail(std::nullopt);
  context_.wait_for_open_faults(0);
}

TEST_F(Ina219ComponentTest, comes_up_without_its_chip) {
  chip_.set_power(false);
  Ina219Component& battery = make();
  ASSERT_TRUE(battery.trigger(Transition::Configure).success);
  ASSERT_TRUE(battery.trigger(Transition::Activate).success);
  EXPECT_EQ(context_.open_faults().size(), 1U) << "reported before the bring-up continues";
  bus_->between_transfers([&] { chip_.set_power(true); });
  allow_long();
  ASSERT_TRUE(context_.wait_for("/battery_state", 1));
  context_.wait_for_open_faults(0);
}

TEST_F(Ina219ComponentTest, a_required_chip_that_is_absent_and_another_chip_are_refused) {
  chip_.set_power(false);
  const auto absent = make({{"required_device", true}}).trigger(Transition::Configure);
  EXPECT_FALSE(absent.success);
  EXPECT_NE(absent.reason.find("INA219 at 0x40 of /dev/i2c-1"), std::string::npos) << absent.reason;

  NodeOptions options{context_};
  Ina219Component other{options, [](const Ina219Options&, const Clock&) {
                          auto bus = std::make_unique<io::ScriptedBus>();
                          bus->attach(0x40, [](ByteView, ByteSpan in) {
                            std::fill(in.begin(), in.end(), std::uint8_t{0x44});
                            return true;
                          });
                          return Result<std::unique_ptr<io::RegisterBus>, Problem>{std::move(bus)};
                        }};
  const auto foreign = other.trigger(Transition::Configure);
  EXPECT_FALSE(foreign.success);
  EXPECT_NE(foreign.reason.find("is no INA219"), std::string::npos) << foreign.reason;
}

TEST(Ina219PublisherCost, taking_readings_allocates_nothing) {
  test::RecordingContext context;
  LifecycleNode node{"test", NodeOptions{context}};
  DeviceWatch watch{node, {}, {"INA219"}, context.clock().now()};
  Ina219Options options;
  options.setup = *ina219_setup(0.1, 3.2, 1s);
  Ina219Publisher sink{options, context.clock(), {}, node.get_logger(), watch};
  const Bytes poll{0, 2, 0, 0x3F, 0xFF, 1, 2, 0, 0x07, 0xD0, 2, 2, 0, 0x5D, 0x9A, 4, 2, 0, 0x20, 0x00};
  const test::AllocationGuard guard;
  for (int i = 0; i < 100; ++i) sink.on_bytes(poll, context.clock().now());
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(sink.counters().line.readings, 100U);
  EXPECT_EQ(sink.counters().strange + sink.counters().unready, 0U);
}

std::string ina219_refusal_of(const std::map<std::string, ParameterValue>& overrides) {
  test::RecordingContext context;
  NodeOptions options{context};
  options.parameter_overrides(overrides);
  Ina219Component battery{options};
  const auto outcome = battery.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  return outcome.reason;
}

TEST(Ina219Parameters, what_is_wrong_is_named_with_the_way_out) {
  const std::string absent =
      ina219_refusal_of({{"port", std::string{"/dev/no_i2c"}}, {"required_device", true}, {"port_timeout", 0.0}});
  EXPECT_NE(absent.find("/dev/no_i2c: no such bus"), std::string::npos) << absent;
  const std::string high = ina219_refusal_of({{"max_current", 10.0}});
  EXPECT_NE(high.find("lower it to 3.2, or fit a smaller shunt"), std::string::npos) << high;
  EXPECT_NE(ina219_refusal_of({{"full_voltage", 9.0}, {"empty_voltage", 12.6}}).find("is not above empty_voltage"),
            std::string::npos);
  const std::string technology = ina219_refusal_of({{"power_supply_technology", std::string{"lipoo"}}});
  EXPECT_NE(technology.find("lipo"), std::string::npos) << technology;
}

}  // namespace
}  // namespace nacelle::battery
