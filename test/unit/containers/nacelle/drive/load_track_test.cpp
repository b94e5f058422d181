// SPDX-License-Identifier: Apache-2.0
#include "drive/model/load_track.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace nacelle::drive {
namespace {

/// Ten seconds of a robot, four samples a second: half a core, from 5 s on a whole one; /fast has 100 Hz and pauses from 6 s to 7 s;
/// /slow has 1 Hz; /late begins at 8 s with 50 Hz.
LoadTrack ten_seconds() {
  LoadTrack track;
  for (int i = 0; i <= 40; ++i) {
    const double t = i * 0.25;
    const double busy = std::min(t, 5.0) * 0.5 + std::max(0.0, t - 5.0);
    const double fast = t <= 6.0 ? t : std::max(6.0, t - 1.0);
    LoadTrack::Counts counts{{"/fast", static_cast<std::uint64_t>(100 * fast)},
                             {"/slow", static_cast<std::uint64_t>(t)}};
    if (t > 8.0) counts.emplace_back("/late", static_cast<std::uint64_t>(50 * (t - 8.0)));
    track.add(t, busy, 20.0 + t, counts);
  }
  return track;
}

TEST(LoadTrack, computes_cpu_load_over_a_second) {
  const auto loads = ten_seconds().cpu_percents();
  ASSERT_FALSE(loads.empty());
  EXPECT_NEAR(loads.front().time_s, 1.0, 1e-9);
  EXPECT_NEAR(loads.front().value, 50.0, 1e-9);
  EXPECT_NEAR(loads.back().value, 100.0, 1e-9);
  EXPECT_NEAR(lowest_of(loads), 50.0, 1e-9);
  EXPECT_NEAR(ten_seconds().rss_mbs().back().value, 30.0, 1e-9);
}

TEST(LoadTrack, finds_the_lowest_rate_of_a_stream) {
  const auto rates = ten_seconds().rates_hz("/fast");
  ASSERT_FALSE(rates.empty());
  EXPECT_NEAR(rates.front().value, 100.0, 1e-9);
  EXPECT_NEAR(lowest_of(rates), 50.0, 1e-9) << "two seconds, of which one was silent";
}

TEST(LoadTrack, does_not_judge_a_stream_before_its_first_message) {
  const auto rates = ten_seconds().rates_hz("/late");
  // From the first sample with messages at 8.25 s, two seconds have not passed.
  EXPECT_TRUE(rates.empty());
  EXPECT_TRUE(std::isnan(lowest_of(rates)));
}

TEST(LoadTrack, takes_a_longer_window_for_a_slow_stream) {
  EXPECT_TRUE(ten_seconds().rates_hz("/slow").empty())
      << "nine messages in ten seconds say nothing about each two of them";
  LoadTrack track;
  for (int i = 0; i <= 400; ++i) track.add(i * 0.25, 0.0, 0.0, {{"/slow", static_cast<std::uint64_t>(i / 4)}});
  EXPECT_NEAR(lowest_of(track.rates_hz("/slow")), 1.0, 0.06);
}

TEST(LoadTrack, knows_nothing_of_an_unknown_stream_or_an_empty_run) {
  EXPECT_TRUE(ten_seconds().rates_hz("/none").empty());
  EXPECT_TRUE(LoadTrack{}.cpu_percents().empty());
  EXPECT_TRUE(LoadTrack{}.rates_hz("/fast").empty());
}

}  // namespace
}  // namespace nacelle::drive
