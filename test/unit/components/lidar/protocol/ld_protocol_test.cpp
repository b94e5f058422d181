// SPDX-License-Identifier: Apache-2.0
#include "lidar/protocol/ld_protocol.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nacelle::lidar {
namespace {

/// The frame number n of an LD06 at 10 turns/s: 12 points each 1/4500 s, 0.8 deg apart; the clock counts whole milliseconds.
Ld06Frame frame_number(int n) {
  Ld06Frame frame;
  frame.speed_dps = 3600;
  frame.first_angle_cdeg = static_cast<std::uint16_t>(n * 960 % 36000);
  frame.last_angle_cdeg = static_cast<std::uint16_t>((n * 960 + 880) % 36000);
  frame.device_time_ms = static_cast<std::uint16_t>(static_cast<int>(n * 8.0 / 3.0) % 30000);
  return frame;
}

TEST(LdClock, counts_as_the_points_do_and_not_in_milliseconds) {
  LdClock clock{4500};
  EXPECT_EQ(clock.step(frame_number(0)), Duration{}) << "the first has none before it";
  Duration sum{};
  for (int n = 1; n <= 22500; ++n) sum += clock.step(frame_number(n));  // a minute, over two restarts of the counter
  EXPECT_NEAR(to_seconds(sum), 60.0, 1e-3);
  for (int n = 22501; n <= 22600; ++n) EXPECT_NEAR(to_seconds(clock.step(frame_number(n))), 8e-3 / 3.0, 1e-6) << n;
}

TEST(LdClock, knows_how_many_packets_were_lost) {
  for (const int lost : {1, 5, 30, 37, 38, 60, 300}) {
    LdClock clock{4500};
    int n = 0;
    for (; n < 100; ++n) static_cast<void>(clock.step(frame_number(n)));
    n += lost;
    EXPECT_NEAR(to_seconds(clock.step(frame_number(n))), (lost + 1) * 8e-3 / 3.0, 2e-6) << lost << " packets lost";
  }
}

TEST(LdClock, never_leaves_the_device_s_clock_even_if_the_rate_is_not_the_model_s) {
  LdClock clock{5000};  // an STL-19P was said, an LD06 is there
  Duration sum{};
  for (int n = 0; n < 1000; ++n) {
    sum += clock.step(frame_number(n));
    EXPECT_NEAR(to_seconds(sum), n * 8e-3 / 3.0, 1.1e-3) << n;
  }
}

TEST(LdClock, a_counter_that_stands_or_jumps_gives_no_step) {
  LdClock clock{4500};
  Ld06Frame frame = frame_number(0);
  Duration sum{};
  for (int n = 0; n < 100; ++n) sum += clock.step(frame);
  EXPECT_LT(sum, 1ms);
  frame.device_time_ms = 20000;
  EXPECT_EQ(clock.step(frame), Duration{}) << "20 s is no packet that was lost";
}

}  // namespace
}  // namespace nacelle::lidar
