// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/arrival_filter.hpp"

#include <gtest/gtest.h>

#include <random>

namespace nacelle::io {
namespace {

TEST(ArrivalFilter, a_late_sample_keeps_its_place_in_the_pace) {
  ArrivalFilter filter;
  MonotonicTime device{1s};
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(filter.settle(device, 10ms), device);
    device += 10ms;
  }
  EXPECT_LE(filter.settle(device + 8ms, 10ms), device + 100us) << "8 ms late, believed 0.1 ms";
}

TEST(ArrivalFilter, is_never_later_than_the_bytes_and_always_goes_forward) {
  const unsigned seed = 12;
  std::mt19937 random{seed};
  ArrivalFilter filter;
  MonotonicTime device{1s}, before{};
  Duration worst{};
  for (int i = 0; i < 5000; ++i) {
    const Duration delay{random() % 10 == 0 ? random() % 15'000'000 : random() % 300'000};
    const MonotonicTime settled = filter.settle(device + delay, 10ms);
    EXPECT_LE(settled, device + delay) << "seed " << seed << ", sample " << i;
    EXPECT_GT(settled, before) << "seed " << seed << ", sample " << i;
    if (i > 10) worst = std::max(worst, settled - device);
    before = settled;
    device += 10ms;
  }
  EXPECT_LT(worst, 1ms) << "delays of up to 15 ms";
}

TEST(ArrivalFilter, follows_a_device_whose_clock_runs_off) {
  for (const double drift : {-0.004, -1e-4, 0.0, 1e-4, 0.004}) {
    ArrivalFilter filter;
    MonotonicTime device{1s};
    for (int i = 0; i < 5000; ++i) {
      const MonotonicTime settled = filter.settle(device, 10ms);
      ASSERT_LE(std::chrono::abs(settled - device), 100us) << "drift " << drift << ", sample " << i;
      device += from_seconds(0.010 * (1.0 + drift));
    }
  }
}

TEST(ArrivalFilter, goes_forward_through_a_burst_that_a_stall_left_behind) {
  ArrivalFilter filter;
  MonotonicTime device{1s}, before = filter.settle(device, 10ms);
  for (int i = 0; i < 30; ++i) {
    device += 10ms;
    // The thread stood still for 250 ms; then everything came at once, counted back from its end at the line's pace.
    const MonotonicTime received = i < 24 ? MonotonicTime{1250ms} - (24 - i) * 5ms : device;
    const MonotonicTime settled = filter.settle(received, 10ms);
    EXPECT_GT(settled, before) << "sample " << i;
    before = settled;
  }
  for (int i = 0; i < 40; ++i) before = filter.settle(device += 10ms, 10ms);
  EXPECT_EQ(before, device) << "and finds the pace again";
}

TEST(ArrivalFilter, believes_a_gap_at_once) {
  ArrivalFilter filter;
  filter.settle({1s}, 10ms);
  EXPECT_EQ(filter.settle({2s}, 10ms), MonotonicTime{2s});
  filter.restart();
  EXPECT_EQ(filter.settle({2010ms}, 1ms), MonotonicTime{2010ms});
}

}  // namespace
}  // namespace nacelle::io
