// SPDX-License-Identifier: Apache-2.0
// The whole loop in told time: controllers, channels (on a tree of files), direction lines, simulated motors and encoders.
#include "diff_drive/port/pwm_base_port.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diff_drive/component/drive_loop.hpp"
#include "pwm_tree.hpp"

namespace nacelle::diff_drive {
namespace {

using Encoder = PwmPlant::Encoder;
using ::testing::HasSubstr;

/// Remembers states and faults.
class Listening final : public WheelStateSink {
 public:
  void on_wheel_state(const WheelState& state) override { last = state; }
  void on_board_fault(const char* fault) override {
    if (fault != nullptr) faults.emplace_back(fault);
    is_over = fault == nullptr;
  }
  WheelState last;
  std::vector<std::string> faults;
  bool is_over = false;
};

struct Base {
  static constexpr double kCounts = 1320.0;  // 11 lines, 4 edges of each, a gear of 30

  explicit Base(Encoder encoder, PwmBasePort::Settings settings = usual()) : plant(tree, clock, encoder, kCounts) {
    settings.counts_per_turn = kCounts;
    port = std::make_unique<PwmBasePort>(plant.motors(), plant.encoders(), clock, settings,
                                         [this](MonotonicTime until) { plant.run_until(until); });
    EXPECT_TRUE(port->start());
  }
  static PwmBasePort::Settings usual() {
    PwmBasePort::Settings settings;
    settings.pid = {.feed_forward = 0.05, .p = 0.02, .i = 0.2};
    return settings;
  }
  void run(const WheelRates& rates, int cycles) {
    for (int cycle = 0; cycle < cycles; ++cycle) {
      ASSERT_TRUE(port->read_until(clock.now() + 20ms, ears));
      ASSERT_TRUE(port->write(rates));
    }
  }

  PwmTree tree;
  ToldClock clock;
  PwmPlant plant;
  std::unique_ptr<PwmBasePort> port;
  Listening ears;
};

class EveryEncoder : public ::testing::TestWithParam<Encoder> {};
INSTANTIATE_TEST_SUITE_P(Pwm, EveryEncoder,
                         ::testing::Values(Encoder::Counter, Encoder::Quadrature, Encoder::OneChannel),
                         [](const auto& each) -> std::string {
                           switch (each.param) {
                             case Encoder::Counter: return "counter";
                             case Encoder::Quadrature: return "quadrature";
                             case Encoder::OneChannel: return "one_channel";
                           }
                           return "";
                         });

TEST_P(EveryEncoder, the_wheels_settle_on_their_speeds_and_stop) {
  Base base{GetParam()};
  base.run({8.0, -5.0}, 100);
  EXPECT_NEAR(base.plant.wheels[0].speed_rps, 8.0, 0.2);
  EXPECT_NEAR(base.plant.wheels[1].speed_rps, -5.0, 0.2);
  EXPECT_NEAR(base.ears.last.rates.left_rps, 8.0, 0.4);
  EXPECT_NEAR(base.ears.last.rates.right_rps, -5.0, 0.4);
  EXPECT_NEAR(base.ears.last.left_rad, base.plant.wheels[0].angle_rad, 0.02);
  EXPECT_NEAR(base.ears.last.right_rad, base.plant.wheels[1].angle_rad, 0.02);
  EXPECT_EQ(base.plant.outputs->levels, 0b1001U) << "IN1 of the left motor, IN2 of the right one";
  ASSERT_TRUE(base.port->stop());
  EXPECT_EQ(base.tree.of_channel(0, "duty_cycle"), "0");
  EXPECT_EQ(base.tree.of_channel(1, "duty_cycle"), "0");
  EXPECT_EQ(base.plant.outputs->levels, 0U) << "they coast";
  EXPECT_TRUE(base.ears.faults.empty());
}

TEST(PwmBasePort, a_dead_band_is_driven_through_and_a_wheel_that_shall_stand_is_off) {
  auto settings = Base::usual();
  settings.min_duty = 0.3;
  Base base{Encoder::Counter, settings};
  for (auto& wheel : base.plant.wheels) wheel.dead_band = 0.3;
  base.run({1.0, 0.0}, 100);
  EXPECT_NEAR(base.plant.wheels[0].speed_rps, 1.0, 0.15);
  EXPECT_GT(base.tree.share(0), 0.3);
  EXPECT_EQ(base.tree.share(1), 0.0);
  EXPECT_EQ(base.plant.outputs->levels, 0b0001U);
}

TEST(PwmBasePort, a_motor_that_is_mounted_the_other_way_round_is_reversed_with_its_encoder) {
  auto settings = Base::usual();
  settings.right.is_reversed = true;
  Base base{Encoder::Quadrature, settings};
  base.run({6.0, 6.0}, 100);
  EXPECT_NEAR(base.plant.wheels[1].speed_rps, -6.0, 0.2);
  EXPECT_NEAR(base.ears.last.rates.right_rps, 6.0, 0.4);
  EXPECT_EQ(base.plant.outputs->levels, 0b1001U);
}

TEST(PwmBasePort, an_encoder_alone_can_be_reversed) {
  auto settings = Base::usual();
  settings.right.encoder_is_reversed = true;
  Base base{Encoder::Quadrature, settings};
  base.plant.encoder_sign[1] = -1.0;
  base.run({6.0, 6.0}, 100);
  EXPECT_NEAR(base.plant.wheels[1].speed_rps, 6.0, 0.2);
  EXPECT_GT(base.ears.last.right_rad, 0.0);
}

TEST(PwmBasePort, a_direction_changes_only_while_the_output_is_off) {
  Base base{Encoder::Counter};
  base.run({8.0, 8.0}, 50);
  class Guard final : public io::GpioOutputs {
   public:
    Guard(PwmTree& tree, std::uint64_t levels) : tree_(tree), levels_(levels) {}
    bool set(std::uint64_t levels) override {
      for (const unsigned motor : {0U, 1U}) {
        const bool turns_over = ((levels ^ levels_) >> (2 * motor) & 3U) != 0;
        EXPECT_TRUE(!turns_over || tree_.of_channel(motor, "duty_cycle") == "0") << motor;
      }
      levels_ = levels;
      ++changes;
      return true;
    }
    bool reopen() override { return true; }
    int changes = 0;

   private:
    PwmTree& tree_;
    std::uint64_t levels_;
  };
  base.port.reset();
  auto guard = std::make_unique<Guard>(base.tree, 0U);
  Guard& lines = *guard;
  const auto channel = [&](unsigned number) {
    return PwmChannel::open({.chip = base.tree.chip(), .channel = number}).value();
  };
  HBridges bridges{channel(0), channel(1), std::move(guard)};
  ASSERT_TRUE(bridges.set(0.5, 0.5));
  ASSERT_TRUE(bridges.set(-0.5, 0.6));
  EXPECT_DOUBLE_EQ(base.tree.share(0), 0.5);
  EXPECT_DOUBLE_EQ(base.tree.share(1), 0.6);
  ASSERT_TRUE(bridges.set(-0.4, -0.4));
  ASSERT_TRUE(bridges.set(-0.3, -0.3));
  EXPECT_EQ(lines.changes, 3) << "lines that stay are not set again";
}

TEST(PwmBasePort, a_blocked_wheel_is_a_fault_that_is_over_when_it_has_rested) {
  Base base{Encoder::Counter};
  base.plant.wheels[0].is_blocked = true;
  base.run({8.0, 8.0}, 150);
  ASSERT_FALSE(base.ears.faults.empty());
  EXPECT_THAT(base.ears.faults.front(), HasSubstr("the left wheel does not turn at full output"));
  EXPECT_FALSE(base.ears.is_over);
  for (int cycle = 0; cycle < 60; ++cycle) {
    ASSERT_TRUE(base.port->stop());
    ASSERT_TRUE(base.port->read_until(base.clock.now() + 20ms, base.ears));
  }
  EXPECT_TRUE(base.ears.is_over);
}

TEST(PwmBasePort, an_encoder_that_counts_backward_is_a_fault_and_no_runaway) {
  Base base{Encoder::Quadrature};
  base.plant.encoder_sign[1] = -1.0;
  base.run({4.0, 4.0}, 120);
  ASSERT_FALSE(base.ears.faults.empty());
  EXPECT_THAT(base.ears.faults.front(), HasSubstr("the right wheel's encoder counts against its motor"));
  EXPECT_THAT(base.ears.faults.front(), HasSubstr("pwm.right_encoder_reversed"));
}

TEST(PwmBasePort, outputs_and_encoders_that_are_gone_are_named_and_come_back) {
  Base base{Encoder::Quadrature};
  base.run({8.0, 8.0}, 50);
  base.plant.inputs->is_lost = true;
  EXPECT_EQ(base.port->read_until(base.clock.now() + 20ms, base.ears).error(), BaseFault::EncodersLost);
  EXPECT_TRUE(base.port->stop()) << "the motors can be stopped all the same";
  EXPECT_EQ(base.port->reopen().error(), BaseFault::EncodersLost);
  base.plant.inputs->is_lost = false;
  ASSERT_TRUE(base.port->reopen());
  base.run({8.0, 8.0}, 50);
  break_channel(base.port->descriptor());
  EXPECT_EQ(base.port->write({8.0, 8.0}).error(), BaseFault::OutputLost);
  EXPECT_EQ(base.port->stop().error(), BaseFault::OutputLost);
  EXPECT_EQ(base.tree.share(1), 0.0) << "the other one is stopped";
  base.plant.outputs->is_lost = true;
  EXPECT_EQ(base.port->reopen().error(), BaseFault::OutputLost);
  base.plant.outputs->is_lost = false;
  ASSERT_TRUE(base.port->reopen());
  base.run({8.0, 8.0}, 50);
  EXPECT_NEAR(base.plant.wheels[0].speed_rps, 8.0, 0.2);
  EXPECT_EQ(base.port->stats().edges_lost, 0U);
  EXPECT_GT(base.port->stats().edges, 1000U);
}

class Silent final : public DriveObserver {
 public:
  void on_wheel_state(const WheelState&) override {}
  void on_cycle(const BodyTwist&, MonotonicTime) override {}
  void on_command_written(Duration) override {}
};

TEST(PwmBasePort, the_drive_loop_drives_it_and_stops_it_when_commands_end) {
  Base base{Encoder::Quadrature};
  CommandInbox inbox;
  Silent observer;
  DriveLoop::Settings settings;
  settings.input.rearm = RearmRule::Fresh;
  DriveLoop loop{settings, *base.port, base.clock, inbox, observer};
  loop.arm(base.clock.now());
  const auto cycle = [&](bool is_commanded) {
    if (is_commanded) inbox.sources[0].commands.put({{0.3, 0.5}, base.clock.now(), base.clock.now()});
    ASSERT_TRUE(loop.cycle());
  };
  for (int i = 0; i < 150; ++i) cycle(true);
  const WheelRates wanted = wheel_rates(settings.geometry, {0.3, 0.5});
  EXPECT_NEAR(base.plant.wheels[0].speed_rps, wanted.left_rps, 0.2);
  EXPECT_NEAR(base.plant.wheels[1].speed_rps, wanted.right_rps, 0.2);
  for (int i = 0; i < 30; ++i) cycle(false);
  EXPECT_EQ(base.tree.share(0), 0.0);
  EXPECT_EQ(base.tree.share(1), 0.0);
  EXPECT_EQ(base.plant.outputs->levels, 0U);
}

TEST(PwmBasePort, the_drive_loop_holds_a_base_whose_wheel_is_blocked) {
  Base base{Encoder::Counter};
  CommandInbox inbox;
  Silent observer;
  DriveLoop::Settings settings;
  settings.input.rearm = RearmRule::Neutral;
  DriveLoop loop{settings, *base.port, base.clock, inbox, observer};
  loop.arm(base.clock.now());
  base.plant.wheels[1].is_blocked = true;
  int driven = 0, held = 0;
  for (int i = 0; i < 400; ++i) {
    inbox.sources[0].commands.put({{i < 60 ? 0.0 : 0.3, 0.0}, base.clock.now(), base.clock.now()});
    ASSERT_TRUE(loop.cycle());
    (base.tree.share(0) > 0.0 ? driven : held) += 1;
  }
  EXPECT_EQ(loop.stats().board_faults, 1U) << "a sender that goes on as before moves nothing";
  EXPECT_LT(driven, 130);
  EXPECT_EQ(base.tree.share(0), 0.0);
}

}  // namespace
}  // namespace nacelle::diff_drive
