// SPDX-License-Identifier: Apache-2.0
#include "range/port/hc_sr04.hpp"

#include <gtest/gtest.h>

#include "range/port/scripted_echo_lines.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::range {
namespace {

struct SensorRig {
  test::ManualClock clock;
  ScriptedEchoLines lines{clock, [this](MonotonicTime until) {
                            if (until > clock.now()) clock.advance(until - clock.now());
                          }};
  HcSr04 sensor{lines, clock};
};

TEST(HcSr04, measures_the_pulse) {
  SensorRig rig;
  for (const Duration pulse : {Duration{116us}, Duration{5830us}, Duration{23300us}}) {
    rig.lines.answer(pulse);
    const auto echo = rig.sensor.measure();
    ASSERT_TRUE(echo);
    EXPECT_EQ(*echo, pulse);
  }
  EXPECT_EQ(rig.lines.triggers(), 3);
}

TEST(HcSr04, a_sensor_that_does_not_answer_is_told_from_an_empty_room) {
  SensorRig rig;
  rig.lines.answer(std::nullopt);
  const MonotonicTime begin = rig.clock.now();
  const auto none = rig.sensor.measure();
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error(), EchoFault::NoPulse);
  EXPECT_EQ(rig.clock.now() - begin, HcSr04::kLongestAnswer);
}

TEST(HcSr04, a_pulse_that_does_not_end_is_no_obstacle_and_no_second_trigger) {
  SensorRig rig;
  rig.lines.answer(200ms);
  EXPECT_EQ(rig.sensor.measure().value(), HcSr04::kNoObstacle);
  rig.lines.answer(5ms);
  EXPECT_EQ(rig.sensor.measure().value(), HcSr04::kNoObstacle) << "the old pulse still lasts";
  EXPECT_EQ(rig.lines.triggers(), 1);
  rig.clock.advance(200ms);
  EXPECT_EQ(rig.sensor.measure().value(), 5ms);
  EXPECT_EQ(rig.lines.triggers(), 2);
}

TEST(HcSr04, a_chip_that_is_gone_and_an_interrupt_are_told) {
  SensorRig rig;
  rig.lines.interrupt();
  EXPECT_EQ(rig.sensor.measure().error(), EchoFault::Woken);
  rig.lines.lose();
  EXPECT_EQ(rig.sensor.measure().error(), EchoFault::Lost);
}

}  // namespace
}  // namespace nacelle::range
