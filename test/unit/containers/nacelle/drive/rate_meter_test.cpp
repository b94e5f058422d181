// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "drive/live_view.hpp"

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

TEST(LiveView, shows_the_rate_of_the_type_that_is_sent_where_two_share_a_name) {
  const auto stats = [](int stamped) {
    const auto stream = [](const char* type, int published) {
      return nlohmann::json{
          {"name", "/cmd_vel"}, {"type", type}, {"published", published}, {"writers", 1}, {"readers", 3}};
    };
    return nlohmann::json{
        {"phase", "running"},
        {"nodes", nlohmann::json::array()},
        {"streams", {stream("geometry_msgs/msg/TwistStamped", stamped), stream("geometry_msgs/msg/Twist", 0)}}};
  };
  ::testing::internal::CaptureStdout();
  LiveView view{false, MonotonicTime{0s}};
  for (int second = 1; second <= 10; ++second) view.show(stats(50 * second), "side 1", MonotonicTime{1s * second});
  const std::string text = ::testing::internal::GetCapturedStdout();
  EXPECT_NE(text.find("/cmd_vel 50\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace nacelle::drive
