// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "nacelle/drive/live_view.hpp"

namespace nacelle::drive {
namespace {

TEST(RateMeter, gives_the_rate_of_the_last_two_seconds) {
  RateMeter meter;
  MonotonicTime now{5s};
  std::uint64_t published = 0;
  for (int i = 0; i < 40; ++i, now += 250ms) meter.note("/scan", published += 25, now);
  EXPECT_NEAR(meter.hz("/scan"), 100, 1e-6);
  for (int i = 0; i < 12; ++i, now += 250ms) meter.note("/scan", published, now);
  EXPECT_EQ(meter.hz("/scan"), 0) << "a stream that went silent";
}

TEST(RateMeter, knows_no_rate_of_a_stream_it_has_seen_once_or_never) {
  RateMeter meter;
  EXPECT_EQ(meter.hz("/scan"), 0);
  meter.note("/scan", 10, MonotonicTime{1s});
  EXPECT_EQ(meter.hz("/scan"), 0);
}

TEST(RateMeter, a_count_that_began_anew_is_no_negative_rate) {
  RateMeter meter;
  meter.note("/scan", 1000, MonotonicTime{1s});
  meter.note("/scan", 3, MonotonicTime{2s});
  EXPECT_GE(meter.hz("/scan"), 0);
}

}  // namespace
}  // namespace nacelle::drive
