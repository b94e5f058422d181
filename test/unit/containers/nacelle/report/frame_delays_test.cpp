// SPDX-License-Identifier: Apache-2.0
#include "report/frame_delays.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nacelle::report {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::int64_t kMs = 1'000'000;

TEST(FrameDelays, show_rate_and_delay_of_each_frame) {
  FrameDelays delays;
  for (std::int64_t i = 0; i <= 10; ++i) delays.note("base", i * 20 * kMs, (i * 20 + (i == 5 ? 9 : 3)) * kMs);
  delays.note("lens", 0, 1 * kMs);

  const auto base = delays.of("base");
  EXPECT_EQ(base.count, 11U);
  EXPECT_NEAR(base.rate_hz, 50.0, 1e-9);
  EXPECT_NEAR(base.average_delay_s, (10 * 0.003 + 0.009) / 11, 1e-12);
  EXPECT_NEAR(base.max_delay_s, 0.009, 1e-12);
  EXPECT_EQ(delays.of("lens").rate_hz, 0.0) << "of one alone";
  EXPECT_EQ(delays.of("unknown").count, 0U);

  const auto all = delays.of_all({"base", "lens", "unknown"});
  EXPECT_EQ(all.count, 12U);
  EXPECT_NEAR(all.rate_hz, 50.0, 1e-9);
  EXPECT_NEAR(all.average_delay_s, (10 * 0.003 + 0.009 + 0.001) / 12, 1e-12);
}

TEST(FrameDelays, a_stamp_of_the_future_is_a_negative_delay) {
  FrameDelays delays;
  delays.note("base", 10 * kMs, 4 * kMs);
  EXPECT_NEAR(delays.of("base").average_delay_s, -0.006, 1e-12);
  EXPECT_NEAR(delays.of("base").max_delay_s, -0.006, 1e-12);
}

TEST(FrameDelays, forget_what_lies_a_thousand_messages_back) {
  FrameDelays delays;
  delays.note("base", 0, 900 * kMs);
  for (int i = 0; i < 1000; ++i) delays.note("base", (1000 + i) * kMs, (1001 + i) * kMs);
  EXPECT_EQ(delays.of("base").count, 1000U);
  EXPECT_NEAR(delays.of("base").max_delay_s, 0.001, 1e-12);
}

TEST(ChainBetween, goes_up_to_the_common_ancestor_and_down_again) {
  const std::map<std::string, std::string> parents{
      {"base", "odom"}, {"lidar", "base"}, {"camera", "base"}, {"lens", "camera"}, {"lonely", "island"}};
  EXPECT_THAT(chain_between(parents, "odom", "lens"), ElementsAre("odom", "base", "camera", "lens"));
  EXPECT_THAT(chain_between(parents, "lens", "lidar"), ElementsAre("lens", "camera", "base", "lidar"));
  EXPECT_THAT(chain_between(parents, "base", "base"), ElementsAre("base"));
  EXPECT_THAT(chain_between(parents, "lens", "lonely"), IsEmpty());
  EXPECT_THAT(chain_between({{"a", "b"}, {"b", "a"}}, "a", "c"), IsEmpty()) << "a circle ends";
}

}  // namespace
}  // namespace nacelle::report
