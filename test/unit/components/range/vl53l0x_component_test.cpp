// SPDX-License-Identifier: Apache-2.0
#include "range/component/vl53l0x_component.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/recording_host.hpp"
#include "vl53l0x_rig.hpp"

namespace nacelle::range {
namespace {

using sensor_msgs::msg::Range;

class Vl53l0xComponentTest : public ::testing::Test {
 protected:
  // The reading thread ends before the chip; stopping the sensor takes a while.
  void TearDown() override {
    if (bus_ != nullptr) allow_long();
    component_.reset();
  }
  Vl53l0xComponent& make(std::map<std::string, ParameterValue> overrides = {}) {
    NodeOptions options{context_};
    options.parameter_overrides(std::move(overrides));
    component_ = std::make_unique<Vl53l0xComponent>(options, [this](const Vl53l0xOptions&, const Clock&) {
      auto bus = make_bus(chip_, context_.clock());
      bus_ = bus.get();
      bus_->allow_until(context_.clock().now() + 2s);  // for set-up
      return Result<std::unique_ptr<io::RegisterBus>, Problem>{std::move(bus)};
    });
    return *component_;
  }
  void bring_up(Vl53l0xComponent& range) {
    const auto configured = range.trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    ASSERT_TRUE(range.trigger(Transition::Activate).success);
    until_ = context_.clock().now() + 2s;
    run(Duration{});
  }
  void run(Duration by) {
    until_ += by;
    bus_->run_until(until_);
  }
  void allow_long() { bus_->allow_until(std::max(until_, context_.clock().now()) + 10'000s); }
  /// Light leaves.
  bool measures() {
    bool measures = false;
    bus_->between_transfers([&] { measures = chip_.measures(); });
    return measures;
  }
  Range last() { return context_.published<Range>("/range").back(); }

  test::RecordingContext context_;
  simulation::Vl53l0xChip chip_;
  io::ScriptedBus* bus_ = nullptr;
  MonotonicTime until_{};
  std::unique_ptr<Vl53l0xComponent> component_;
};

TEST_F(Vl53l0xComponentTest, publishes_ranges_with_every_field_set_at_its_rate) {
  chip_.look_at({.distance_mm = 1234});
  Vl53l0xComponent& range = make({{"rate", 20.0}});
  ASSERT_NO_FATAL_FAILURE(bring_up(range));
  const std::size_t before = context_.published<Range>("/range").size();
  run(2s);
  const auto messages = context_.published<Range>("/range");
  EXPECT_NEAR(static_cast<double>(messages.size() - before), 40.0, 1.0);
  EXPECT_EQ(last().header.frame_id, "range_link");
  EXPECT_EQ(last().radiation_type, Range::INFRARED);
  EXPECT_FLOAT_EQ(last().field_of_view, 0.44F);
  EXPECT_FLOAT_EQ(last().min_range, 0.03F);
  EXPECT_FLOAT_EQ(last().max_range, 2.0F);
  EXPECT_FLOAT_EQ(last().range, 1.234F);
  EXPECT_TRUE(context_.open_faults().empty());
  for (std::size_t i = before + 1; i < messages.size(); ++i) {
    const Duration step = time_of(messages[i].header.stamp) - time_of(messages[i - 1].header.stamp);
    EXPECT_NEAR(to_seconds(step), 0.05, to_seconds(Vl53l0xStream::kLook)) << i;
  }
}

TEST_F(Vl53l0xComponentTest, tells_nothing_in_range_from_too_near_and_from_no_measurement) {
  Vl53l0xComponent& range = make();
  ASSERT_NO_FATAL_FAILURE(bring_up(range));
  const auto see = [&](std::uint8_t code, std::uint16_t mm) {
    bus_->between_transfers([&] { chip_.look_at({.code = code, .distance_mm = mm}); });
    run(300ms);
    return last().range;
  };
  EXPECT_EQ(see(4, 8190), std::numeric_limits<float>::infinity());
  EXPECT_EQ(see(11, 2500), std::numeric_limits<float>::infinity());
  EXPECT_EQ(see(11, 12), -std::numeric_limits<float>::infinity());
  EXPECT_TRUE(std::isnan(see(7, 700)));
  EXPECT_FLOAT_EQ(see(11, 700), 0.7F);
  EXPECT_TRUE(context_.open_faults().empty());
}

TEST_F(Vl53l0xComponentTest, only_an_active_node_measures) {
  Vl53l0xComponent& range = make();
  ASSERT_TRUE(range.trigger(Transition::Configure).success);
  EXPECT_FALSE(measures());
  allow_long();
  for (int round = 0; round < 2; ++round) {
    ASSERT_TRUE(range.trigger(Transition::Activate).success);
    EXPECT_TRUE(measures()) << round;
    ASSERT_TRUE(range.trigger(Transition::Deactivate).success);
    EXPECT_FALSE(measures()) << round;
  }
  ASSERT_TRUE(range.trigger(Transition::Activate).success);
  ASSERT_TRUE(range.trigger(Transition::Shutdown).success);
  EXPECT_FALSE(chip_.measures()) << "stopped before the bus is closed";
  bus_ = nullptr;
}

TEST_F(Vl53l0xComponentTest, a_sensor_that_lost_its_power_is_an_open_fault_until_it_is_back_and_set_up_again) {
  Vl53l0xComponent& range = make();
  ASSERT_NO_FATAL_FAILURE(bring_up(range));
  ASSERT_TRUE(context_.wait_for("/range", 3));
  bus_->between_transfers([&] { chip_.set_power(false); });
  allow_long();
  context_.wait_for_open_faults(1);
  EXPECT_EQ(context_.open_faults()[0].code, kDeviceLost);
  EXPECT_NE(context_.open_faults()[0].text.find("VL53L0X at 0x29 of /dev/i2c-1"), std::string::npos);
  bus_->between_transfers([&] { chip_.set_power(true); });
  context_.wait_for_open_faults(0);
  const std::size_t before = context_.published<Range>("/range").size();
  ASSERT_TRUE(context_.wait_for("/range", before + 2));
  EXPECT_EQ(range.get_current_state().state(), StateId::Active);
}

TEST_F(Vl53l0xComponentTest, a_short_loss_of_power_behind_a_bus_that_works_is_set_up_again) {
  Vl53l0xComponent& range = make();
  ASSERT_NO_FATAL_FAILURE(bring_up(range));
  ASSERT_TRUE(context_.wait_for("/range", 3));
  bus_->between_transfers([&] { chip_.set_power(true); });  // between two polls: no transfer fails
  const std::size_t before = context_.published<Range>("/range").size();
  allow_long();
  ASSERT_TRUE(context_.wait_for("/range", before + 2));
  context_.wait_for_open_faults(0);
}

TEST_F(Vl53l0xComponentTest, a_stuck_bus_is_an_open_fault_until_it_is_free) {
  Vl53l0xComponent& range = make();
  ASSERT_NO_FATAL_FAILURE(bring_up(range));
  ASSERT_TRUE(context_.wait_for("/range", 3));
  bus_->fail(io::StreamFault::BusStuck);
  allow_long();
  context_.wait_for_open_faults(1);
  bus_->fail(std::nullopt);
  context_.wait_for_open_faults(0);
}

TEST_F(Vl53l0xComponentTest, comes_up_without_its_sensor) {
  chip_.set_power(false);
  Vl53l0xComponent& range = make();
  ASSERT_TRUE(range.trigger(Transition::Configure).success);
  ASSERT_TRUE(range.trigger(Transition::Activate).success);
  EXPECT_EQ(context_.open_faults().size(), 1U) << "reported before the bring-up continues";
  bus_->between_transfers([&] { chip_.set_power(true); });
  allow_long();
  ASSERT_TRUE(context_.wait_for("/range", 1));
  context_.wait_for_open_faults(0);
}

TEST_F(Vl53l0xComponentTest, a_required_sensor_that_is_absent_and_another_chip_are_refused) {
  chip_.set_power(false);
  const auto absent = make({{"required_device", true}}).trigger(Transition::Configure);
  bus_ = nullptr;  // closed
  EXPECT_FALSE(absent.success);
  EXPECT_NE(absent.reason.find("VL53L0X at 0x29 of /dev/i2c-1"), std::string::npos) << absent.reason;

  NodeOptions options{context_};
  Vl53l0xComponent other{options, [](const Vl53l0xOptions&, const Clock&) {
                           auto bus = std::make_unique<io::ScriptedBus>();
                           bus->attach(0x29, [](ByteView, ByteSpan in) {
                             std::fill(in.begin(), in.end(), std::uint8_t{0x44});
                             return true;
                           });
                           return Result<std::unique_ptr<io::RegisterBus>, Problem>{std::move(bus)};
                         }};
  const auto foreign = other.trigger(Transition::Configure);
  EXPECT_FALSE(foreign.success);
  EXPECT_NE(foreign.reason.find("is no VL53L0X"), std::string::npos) << foreign.reason;
}

std::string vl53l0x_refusal_of(const std::map<std::string, ParameterValue>& overrides) {
  test::RecordingContext context;
  NodeOptions options{context};
  options.parameter_overrides(overrides);
  Vl53l0xComponent range{options};
  const auto outcome = range.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  return outcome.reason;
}

TEST(Vl53l0xParameters, what_is_wrong_is_named_with_the_way_out) {
  const std::string absent =
      vl53l0x_refusal_of({{"port", std::string{"/dev/no_i2c"}}, {"required_device", true}, {"port_timeout", 0.0}});
  EXPECT_NE(absent.find("/dev/no_i2c: no such bus"), std::string::npos) << absent;
  EXPECT_NE(vl53l0x_refusal_of({{"rate", 30.0}}).find("lower it or rate"), std::string::npos);
  EXPECT_NE(vl53l0x_refusal_of({{"min_range", 3.0}}).find("max_range"), std::string::npos);
}

}  // namespace
}  // namespace nacelle::range
