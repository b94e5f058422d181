// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/arrival_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace nacelle::io {
namespace {

TEST(ArrivalFilter, a_late_sample_keeps_its_place_in_the_pace) {
  ArrivalFilter filter;
  MonotonicTime device{1s};
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(filter.settle(device, 0ms, 10ms), device);
    device += 10ms;
  }
  EXPECT_LE(filter.settle(device + 8ms, 0ms, 10ms), device + 100us) << "8 ms late, believed 0.1 ms";
}

TEST(ArrivalFilter, is_never_later_than_the_bytes_and_always_goes_forward) {
  const unsigned seed = 12;
  std::mt19937 random{seed};
  ArrivalFilter filter;
  MonotonicTime device{1s}, before{};
  Duration worst{};
  for (int i = 0; i < 5000; ++i) {
    const Duration delay{random() % 10 == 0 ? random() % 15'000'000 : random() % 300'000};
    const MonotonicTime settled = filter.settle(device + delay, 0ms, 10ms);
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
      const MonotonicTime settled = filter.settle(device, 0ms, 10ms);
      ASSERT_LE(std::chrono::abs(settled - device), 100us) << "drift " << drift << ", sample " << i;
      device += from_seconds(0.010 * (1.0 + drift));
    }
  }
}

TEST(ArrivalFilter, keeps_the_pace_over_a_first_window_of_exactly_its_length) {
  ArrivalFilter filter{ArrivalFilter::Steps::Nominal};
  MonotonicTime device{1s};
  for (int i = 0; i < 120; ++i) {
    ASSERT_EQ(filter.settle(device, 0ms, 10ms), device) << "sample " << i;
    device += 10ms;
  }
}

TEST(ArrivalFilter, is_settled_when_a_rate_that_only_a_data_sheet_gives_is_measured) {
  for (const double error : {-0.03, -1e-4, 1e-4, 0.03}) {
    const unsigned seed = 13;
    std::mt19937 random{seed};
    ArrivalFilter filter{ArrivalFilter::Steps::Nominal};
    MonotonicTime device{1s}, settled_at{};
    Duration earliest = Duration::max(), latest = Duration::min();
    for (int i = 0; i < 3000; ++i) {
      const MonotonicTime settled = filter.settle(device + Duration{random() % 3'000'000}, 0ms, 10ms);
      if (filter.is_settled()) {
        if (settled_at == MonotonicTime{}) settled_at = device;
        earliest = std::min(earliest, settled - device);
        latest = std::max(latest, settled - device);
      }
      device += from_seconds(0.010 * (1.0 + error));
    }
    EXPECT_LT(settled_at, MonotonicTime{1s} + 5s) << error;
    EXPECT_LT(latest - earliest, 1ms) << error << ", seed " << seed;
  }
}

TEST(ArrivalFilter, takes_a_rate_that_cannot_be_measured_as_it_is) {
  ArrivalFilter filter{ArrivalFilter::Steps::Nominal};
  MonotonicTime device{1s};
  int samples = 0;
  for (; !filter.is_settled() && samples < 1000; ++samples) {
    // A gap after each half second: no two windows are whole.
    device += samples % 50 == 0 ? 300ms : 10ms;
    static_cast<void>(filter.settle(device, 0ms, 10ms));
  }
  EXPECT_NEAR(samples, 500, 5);
}

TEST(ArrivalFilter, keeps_the_place_of_each_sample_in_a_burst_that_waited_for_the_thread) {
  constexpr Duration kOnLine = 5ms;
  for (const Duration away : {90ms, 250ms, 600ms, 900ms}) {
    for (const int in_one_read : {1, 7, 100}) {
      ArrivalFilter filter;
      MonotonicTime device{1s};
      filter.settle(device + kOnLine, kOnLine, 10ms);
      const MonotonicTime back = device + away;
      for (MonotonicTime read = back; device < back + 100ms;) {
        // Up to in_one_read samples wait; each left the device before those that are read with it.
        const int waiting = static_cast<int>((read - kOnLine - device) / 10ms);
        const int count = std::clamp(waiting, 0, in_one_read);
        for (int i = 0; i < count; ++i) {
          device += 10ms;
          const MonotonicTime settled = filter.settle(read, (count - i) * kOnLine, 10ms);
          EXPECT_LE(settled - device, 100us * (1 + (device - MonotonicTime{1s}) / 10ms))
              << "believed a little late at each step";
          EXPECT_GE(settled, device - 100us) << away.count() << " ns away, " << in_one_read << " in a read";
        }
        read += count > 0 ? Duration{200us} : Duration{10ms};
      }
    }
  }
}

TEST(ArrivalFilter, believes_a_gap_with_the_second_sample_after_it) {
  ArrivalFilter filter;
  filter.settle({1s}, 0ms, 10ms);
  EXPECT_EQ(filter.settle({1500ms}, 0ms, 10ms), MonotonicTime{1010ms}) << "it may be the first of a burst";
  EXPECT_EQ(filter.settle({1510ms}, 0ms, 10ms), MonotonicTime{1510ms});
  EXPECT_EQ(filter.settle({1520ms}, 0ms, 10ms), MonotonicTime{1520ms});
  EXPECT_EQ(filter.settle({3s}, 0ms, 10ms), MonotonicTime{3s}) << "no line keeps so much";
  filter.restart();
  EXPECT_EQ(filter.settle({3010ms}, 0ms, 1ms), MonotonicTime{3010ms});
}

TEST(ArrivalFilter, goes_forward_through_a_burst_that_comes_after_a_gap_was_believed) {
  ArrivalFilter filter;
  filter.settle({1s}, 0ms, 10ms);
  filter.settle({1500ms}, 0ms, 10ms);
  MonotonicTime before = filter.settle({1510ms}, 0ms, 10ms);
  for (int i = 0; i < 20; ++i) {
    const MonotonicTime settled = filter.settle({1511ms}, 0ms, 10ms);
    EXPECT_GT(settled, before) << "sample " << i;
    before = settled;
  }
  MonotonicTime device{1600ms};
  for (int i = 0; i < 40; ++i) before = filter.settle(device += 10ms, 0ms, 10ms);
  EXPECT_EQ(before, device) << "and finds the pace again";
}

}  // namespace
}  // namespace nacelle::io
