// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/histogram.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle {
namespace {

enum class Fault { Small };

Result<int, Fault> at_least_three(int n) {
  if (n < 3) return err(Fault::Small);
  return n;
}

TEST(Result, holds_the_value_or_the_reason) {
  EXPECT_EQ(at_least_three(4).value(), 4);
  EXPECT_EQ(at_least_three(2).error(), Fault::Small);
}

TEST(Hex, round_trips_every_byte) {
  Bytes all(256);
  for (int i = 0; i < 256; ++i) all[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(i);
  Bytes back;
  ASSERT_TRUE(from_hex(to_hex(all), back));
  EXPECT_EQ(back, all);
}

TEST(Hex, refuses_half_a_byte_and_other_letters) {
  Bytes out;
  EXPECT_FALSE(from_hex("abc", out));
  EXPECT_FALSE(from_hex("0g", out));
}

TEST(NearestName, finds_a_slip_of_the_fingers_and_nothing_else) {
  const std::vector<std::string> names{"frame_id", "port_name", "baudrate"};
  EXPECT_EQ(nearest_name("port_nam", names), "port_name");
  EXPECT_EQ(nearest_name("braudate", names), "baudrate");
  EXPECT_EQ(nearest_name("exposure", names), "");
  EXPECT_EQ(nearest_name("port", names), "");
  // The distance of two texts takes memory in proportion to the product of their lengths.
  EXPECT_EQ(nearest_name(std::string(1'000'000, 'x'), {"port_name", std::string(999'999, 'x')}), "");
  EXPECT_EQ(suggestion("port", names), "did you mean 'port_name'?") << "its first word";
  EXPECT_EQ(suggestion("exposure", {"/scan", "/cmd_vel", "/cmd_vel"}), "one of /scan, /cmd_vel") << "each once";
}

TEST(Problem, says_where_what_and_the_way_out) {
  EXPECT_EQ((Problem{"a.yaml:3", "no such key 'x'", "did you mean 'y'?"}).text(),
            "a.yaml:3: no such key 'x'; did you mean 'y'?");
  EXPECT_EQ((Problem{"", "broken", ""}).text(), "broken");
}

TEST(DurationHistogram, tells_a_quantile_within_its_bucket_width) {
  DurationHistogram histogram;
  std::mt19937 random{7};
  std::uniform_int_distribution<int> any{1000, 1000000};
  std::vector<int> values;
  for (int i = 0; i < 10000; ++i) {
    values.push_back(any(random));
    histogram.record(Duration{values.back()});
  }
  std::sort(values.begin(), values.end());
  for (const double share : {0.5, 0.9, 0.99}) {
    const double exact = values[static_cast<std::size_t>(share * 10000) - 1];
    const auto told = static_cast<double>(histogram.quantile(share).count());
    EXPECT_GE(told, exact) << share;
    EXPECT_LE(told, exact * 1.126) << share;
  }
  EXPECT_EQ(histogram.max().count(), values.back());
  EXPECT_EQ(histogram.count(), 10000U);
}

TEST(DurationHistogram, tells_the_sum_within_half_a_bucket) {
  DurationHistogram histogram;
  EXPECT_EQ(histogram.total(), Duration::zero());
  double exact = 0;
  std::mt19937 random{7};
  std::uniform_int_distribution<int> any{1, 1000000};
  for (int i = 0; i < 1000; ++i) {
    const int value = any(random);
    exact += value;
    histogram.record(Duration{value});
    ASSERT_NEAR(static_cast<double>(histogram.total().count()), exact, exact / 16 + 1) << i;
  }
  for (int i = 0; i < 2; ++i) histogram.record(Duration::max());
  EXPECT_EQ(histogram.total(), Duration::max()) << "more than there is room for";
}

TEST(DurationHistogram, takes_zero_and_the_longest_duration) {
  DurationHistogram histogram;
  histogram.record(Duration{0});
  histogram.record(Duration{-5});
  histogram.record(Duration::max());
  EXPECT_EQ(histogram.count(), 3U);
  EXPECT_EQ(histogram.quantile(1.0), Duration::max());
}

struct Stamp {  // as builtin_interfaces/msg/Time
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};

TEST(WallTime, is_a_messages_stamp_and_back_also_before_1970) {
  for (const Duration since :
       {Duration{0}, Duration{1'700'000'000'123'456'789}, Duration{-1}, Duration{-1'500'000'000}}) {
    const WallTime time{since};
    const Stamp stamp = time;
    EXPECT_LT(stamp.nanosec, 1'000'000'000U);
    EXPECT_EQ(time_of(stamp), time) << since.count();
  }
  const Stamp before = WallTime{Duration{-1}};
  EXPECT_EQ(before.sec, -1);
  EXPECT_EQ(before.nanosec, 999'999'999U);
}

}  // namespace
}  // namespace nacelle
