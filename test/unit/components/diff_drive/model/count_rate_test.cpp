// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/count_rate.hpp"

#include <gtest/gtest.h>

namespace nacelle::diff_drive {
namespace {

MonotonicTime at(Duration time) { return MonotonicTime{100s + time}; }

TEST(CountRate, without_times_of_edges_is_the_difference_quotient) {
  CountRate rate;
  EXPECT_EQ(rate.update(50, std::nullopt, at(0ms)), 0.0) << "where it starts says nothing";
  EXPECT_DOUBLE_EQ(rate.update(60, std::nullopt, at(20ms)), 500.0);
  EXPECT_DOUBLE_EQ(rate.update(50, std::nullopt, at(40ms)), -500.0);
  EXPECT_DOUBLE_EQ(rate.update(50, std::nullopt, at(60ms)), 0.0);
}

TEST(CountRate, with_times_of_edges_is_exact_for_a_slow_wheel) {
  // 170 edges per second, looked at every 20 ms: 3 or 4 edges, which the difference quotient would make 150 or 200 of.
  CountRate rate;
  constexpr Duration kEdge = Duration{1s} / 170;
  static_cast<void>(rate.update(0, std::nullopt, at(0ms)));
  for (std::int64_t look = 1; look < 100; ++look) {
    const Duration now = look * 20ms;
    const std::int64_t edges = now / kEdge;
    const double found = rate.update(edges, at(edges * kEdge), at(now));
    if (look > 2) { EXPECT_NEAR(found, 170.0, 0.01); }
  }
}

TEST(CountRate, a_wheel_that_runs_out_slows_down_without_an_edge) {
  CountRate rate;
  static_cast<void>(rate.update(0, at(0ms), at(0ms)));
  static_cast<void>(rate.update(10, at(20ms), at(20ms)));
  EXPECT_DOUBLE_EQ(rate.update(20, at(40ms), at(40ms)), 500.0);
  EXPECT_DOUBLE_EQ(rate.update(20, at(40ms), at(60ms)), 50.0) << "or there would have been an edge";
  EXPECT_DOUBLE_EQ(rate.update(20, at(40ms), at(140ms)), 10.0);
  EXPECT_DOUBLE_EQ(rate.update(20, at(40ms), at(541ms)), 0.0);
}

TEST(CountRate, the_first_edges_after_a_standstill_count_from_the_last_look) {
  CountRate rate;
  static_cast<void>(rate.update(0, at(0ms), at(0ms)));
  static_cast<void>(rate.update(0, at(0ms), at(10s)));
  EXPECT_DOUBLE_EQ(rate.update(5, at(10s + 10ms), at(10s + 20ms)), 500.0);
  EXPECT_DOUBLE_EQ(rate.update(0, at(10s + 20ms), at(10s + 20ms)), -500.0) << "the way back";
}

TEST(CountRate, a_reset_forgets_what_was_counted) {
  CountRate rate;
  static_cast<void>(rate.update(0, std::nullopt, at(0ms)));
  rate.reset();
  EXPECT_EQ(rate.update(900, std::nullopt, at(20ms)), 0.0);
  EXPECT_EQ(rate.update(900, std::nullopt, at(20ms)), 0.0) << "no time has passed";
}

}  // namespace
}  // namespace nacelle::diff_drive
