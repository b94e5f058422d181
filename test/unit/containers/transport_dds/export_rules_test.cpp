// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/export_rules.hpp"

#include <gtest/gtest.h>

namespace nacelle::transport_dds {
namespace {

constexpr MonotonicTime kStart{Duration{50s}};

/// How many of `count` messages that come every `period` may go.
int admitted(ExportGate& gate, int count, Duration period, std::size_t bytes = 1, MonotonicTime from = kStart) {
  int gone = 0;
  for (int i = 0; i < count; ++i) gone += gate.admits(from + period * i, bytes) ? 1 : 0;
  return gone;
}

TEST(ExportRules, show_what_they_name) {
  const std::vector<ExportRule> rules{{"/scan"}, {"/camera/image_raw", 5}};
  EXPECT_EQ(rule_of(rules, "/scan", "sensor_msgs/msg/LaserScan"), &rules[0]);
  EXPECT_EQ(rule_of(rules, "/camera/image_raw", "sensor_msgs/msg/Image"), &rules[1]);
  EXPECT_EQ(rule_of(rules, "/scan/more", "sensor_msgs/msg/LaserScan"), nullptr);
  EXPECT_EQ(rule_of(rules, "/tf", "tf2_msgs/msg/TFMessage"), nullptr) << "a list means a list";
  EXPECT_EQ(rule_of({}, "/scan", "sensor_msgs/msg/LaserScan"), nullptr);
}

TEST(ExportRules, show_only_the_compressed_form_where_they_say_so) {
  const std::vector<ExportRule> rules{{"/image", 0, 0, true}};
  EXPECT_EQ(rule_of(rules, "/image", "sensor_msgs/msg/Image"), nullptr);
  EXPECT_EQ(rule_of(rules, "/image/compressed", "sensor_msgs/msg/CompressedImage"), rules.data());
  EXPECT_EQ(rule_of(rules, "/image/theora", "theora_image_transport/msg/Packet"), rules.data());
  EXPECT_EQ(rule_of(rules, "/image", "sensor_msgs/msg/CompressedImage"), rules.data());
  EXPECT_EQ(rule_of(rules, "/image/camera_info", "sensor_msgs/msg/CameraInfo"), nullptr);
  EXPECT_EQ(rule_of(rules, "/images/compressed", "sensor_msgs/msg/CompressedImage"), nullptr);
}

TEST(ExportGate, without_limits_lets_everything_through) {
  ExportGate gate{ExportRule{"/a"}};
  EXPECT_EQ(admitted(gate, 1000, Duration{1}, 1U << 30U), 1000);
}

TEST(ExportGate, keeps_a_rate_on_the_average) {
  for (const double hz : {30.0, 50.0, 13.0, 1000.0}) {
    ExportGate gate{{"/a", 10}};
    const int gone = admitted(gate, static_cast<int>(hz * 20), from_seconds(1 / hz));
    EXPECT_NEAR(gone, 200, 2) << hz << " Hz";
  }
}

TEST(ExportGate, lets_a_slower_topic_through_whole) {
  ExportGate gate{{"/a", 10}};
  EXPECT_EQ(admitted(gate, 50, 101ms), 50);
}

TEST(ExportGate, pays_no_pause_back_in_a_burst) {
  ExportGate gate{{"/a", 10}};
  EXPECT_TRUE(gate.admits(kStart, 1));
  EXPECT_LE(admitted(gate, 100, 1ms, 1, kStart + 60s), 2);
}

TEST(ExportGate, keeps_bytes_per_second_after_the_first_second_in_store) {
  ExportGate gate{{"/a", 0, 10'000}};
  // 100 kB/s for ten seconds: the initial allowance, and that of ten seconds.
  EXPECT_NEAR(admitted(gate, 1000, 10ms, 1000), 110, 2);
}

TEST(ExportGate, lets_a_message_go_that_is_larger_than_a_seconds_worth_and_waits_until_it_is_paid_for) {
  ExportGate gate{{"/a", 0, 1000}};
  EXPECT_TRUE(gate.admits(kStart, 5000));
  EXPECT_FALSE(gate.admits(kStart + 4s, 1));
  EXPECT_TRUE(gate.admits(kStart + 4s + 10ms, 1));
  EXPECT_FALSE(gate.admits(kStart + 5s, 5000)) << "the store is not full";
  EXPECT_TRUE(gate.admits(kStart + 5s + 20ms, 5000));
}

TEST(ExportGate, tells_when_a_message_may_go) {
  ExportGate gate{{"/a", 10, 1000}};
  EXPECT_EQ(gate.due(kStart, 10), kStart);
  ASSERT_TRUE(gate.admits(kStart, 1000));
  for (const std::size_t bytes : {10U, 200U, 1000U, 9000U}) {
    const MonotonicTime due = gate.due(kStart, bytes);
    ExportGate early = gate, then = gate;
    EXPECT_FALSE(early.admits(due - 1ms, bytes)) << bytes;
    EXPECT_TRUE(then.admits(due, bytes)) << bytes;
  }
}

TEST(ExportGate, bears_times_that_go_back) {
  ExportGate gate{{"/a", 0, 1000}};
  EXPECT_TRUE(gate.admits(kStart, 500));
  EXPECT_TRUE(gate.admits(kStart - 1s, 500));
  EXPECT_FALSE(gate.admits(kStart - 1s, 500));
  EXPECT_TRUE(gate.admits(kStart + 500ms, 499));
}

}  // namespace
}  // namespace nacelle::transport_dds
