// SPDX-License-Identifier: Apache-2.0
// A control cycle over a real line allocates nothing. This file replaces operator new for its whole program.
#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "../port/base_rig.hpp"
#include "../port/pwm_tree.hpp"
#include "diff_drive/component/drive_loop.hpp"

namespace {
thread_local std::uint64_t allocations = 0;
}

void* operator new(std::size_t size) {
  ++allocations;
  void* const memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc{};
  return memory;
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace nacelle::diff_drive {
namespace {

class Counting final : public DriveObserver {
 public:
  void on_wheel_state(const WheelState&) override { ++states; }
  void on_cycle(const BodyTwist&, MonotonicTime) override {}
  void on_command_written(Duration) override { ++commands; }
  int states = 0;
  int commands = 0;
};

TEST(DriveLoopAllocations, a_cycle_that_reads_limits_and_writes_has_none) {
  WaveshareRig rig;
  CommandInbox inbox;
  Counting observer;
  AxisLimits limits;
  limits.max_velocity = 0.5;
  limits.max_acceleration = 1.0;
  limits.max_jerk = 20.0;
  DriveLoop::Settings settings;
  settings.period = 2ms;
  settings.limits = {resolved(limits).value(), resolved(limits).value()};
  settings.silence_limit = 10s;
  DriveLoop loop{settings, rig.port(), rig.clock(), inbox, observer};
  ASSERT_TRUE(rig.port().start());
  loop.arm(rig.clock().now());

  std::uint64_t in_cycles = 0;
  for (int i = 0; i < 200; ++i) {
    rig.board.say(0.002);
    if (i % 3 == 0) rig.board.send("noise and {\"T\":1002,\"r\":1.5}\n");
    const MonotonicTime now = rig.clock().now();
    inbox.sources[0].commands.put({{0.001 * i, -0.003 * i}, now, now});
    const std::uint64_t before = allocations;
    const auto done = loop.cycle();
    in_cycles += allocations - before;
    ASSERT_TRUE(done);
  }

  EXPECT_EQ(in_cycles, 0U);
  EXPECT_GT(observer.states, 100);
  EXPECT_GT(observer.commands, 100);
  EXPECT_GT(allocations, 0U) << "the counter counts";
}

TEST(DriveLoopAllocations, a_cycle_that_controls_motors_on_pins_has_none) {
  PwmTree tree;
  ToldClock clock;
  for (const auto encoder : {PwmPlant::Encoder::Counter, PwmPlant::Encoder::Quadrature}) {
    PwmPlant plant{tree, clock, encoder, 1320.0};
    PwmBasePort::Settings port_settings;
    port_settings.counts_per_turn = 1320.0;
    port_settings.pid = {.feed_forward = 0.05, .p = 0.02, .i = 0.2, .d = 0.001};
    std::uint64_t of_the_plant = 0;
    PwmBasePort port{plant.motors(), plant.encoders(), clock, port_settings, [&](MonotonicTime until) {
                       const std::uint64_t before = allocations;
                       plant.run_until(until);
                       of_the_plant += allocations - before;
                     }};
    CommandInbox inbox;
    Counting observer;
    DriveLoop loop{{}, port, clock, inbox, observer};
    ASSERT_TRUE(port.start());
    loop.arm(clock.now());
    std::uint64_t in_cycles = 0;
    for (int i = 0; i < 120; ++i) {
      inbox.sources[0].commands.put({{i < 40 ? 0.0 : 0.2, 0.0}, clock.now(), clock.now()});
      const std::uint64_t before = allocations;
      ASSERT_TRUE(loop.cycle());
      in_cycles += allocations - before;
    }
    EXPECT_EQ(in_cycles - of_the_plant, 0U);
    EXPECT_GT(observer.states, 100);
    EXPECT_GT(plant.wheels[0].speed_rps, 1.0);
  }
}

}  // namespace
}  // namespace nacelle::diff_drive
