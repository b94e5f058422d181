// SPDX-License-Identifier: Apache-2.0
#include "record/model/recording_diff.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nav_msgs/msg/odometry.hpp>
#include <sensor_msgs/msg/laser_scan.hpp>
#include <std_msgs/msg/int64.hpp>
#include <std_msgs/msg/string.hpp>

#include "record/protocol/mcap_writer.hpp"
#include "seen_file.hpp"

namespace nacelle::record {
namespace {

using nav_msgs::msg::Odometry;
using sensor_msgs::msg::LaserScan;

constexpr std::uint64_t kNsPerS = 1'000'000'000U;

Tolerances tolerances(const char* yaml) {
  auto parsed = Tolerances::parse(yaml, "tolerances.yaml");
  EXPECT_TRUE(parsed) << parsed.error().text();
  return parsed ? std::move(*parsed) : Tolerances{};
}

TEST(Tolerances, the_longest_path_decides_and_a_path_covers_what_is_in_it) {
  const auto all = tolerances(R"(
"*": {header.stamp: {ignore: true}, pose: 5.0}
/odom:
  pose: 1.0
  pose.covariance: 2
  pose.covariance[7]: 3e-3
  pose.pose.position.x: {tolerance: 0.5}
)");
  const auto at_pose = all.of_topic("/odom").field("pose");
  EXPECT_EQ(at_pose.allowance().tolerance, 1.0) << "the topic's own is after that of every topic";
  EXPECT_EQ(at_pose.field("pose").field("position").field("x").allowance().tolerance, 0.5);
  EXPECT_EQ(at_pose.field("pose").field("position").field("y").allowance().tolerance, 1.0);
  const auto covariance = at_pose.field("covariance");
  EXPECT_FALSE(covariance.elements_are_alike());
  EXPECT_EQ(covariance.element(6).allowance().tolerance, 2.0);
  EXPECT_EQ(covariance.element(7).allowance().tolerance, 3e-3);
  EXPECT_TRUE(all.of_topic("/odom").field("header").field("stamp").allowance().ignore);
  EXPECT_FALSE(all.of_topic("/odom").field("header").field("frame_id").allowance().ignore);
  EXPECT_EQ(all.of_topic("/other").field("pose").allowance().tolerance, 5.0);
  EXPECT_EQ(all.of_topic("/other").field("twist").allowance().tolerance, 0.0);
}

TEST(Tolerances, a_wildcard_stands_for_every_index) {
  const auto all = tolerances("/scan: {'ranges[*]': 0.01}");
  const auto ranges = all.of_topic("/scan").field("ranges");
  EXPECT_TRUE(ranges.elements_are_alike());
  EXPECT_EQ(ranges.allowance().tolerance, 0.0) << "not of the list itself";
  EXPECT_EQ(ranges.element(99).allowance().tolerance, 0.01);
}

TEST(Tolerances, refuse_what_is_wrong_with_its_line) {
  const std::vector<std::tuple<const char*, int, ToleranceFault>> cases{
      {"[1, 2]", 1, ToleranceFault::WrongShape},
      {"odom: {x: 1}", 1, ToleranceFault::WrongShape},
      {"/odom: 0.1", 1, ToleranceFault::WrongShape},
      {"/odom:\n  x: {allow: 1}", 2, ToleranceFault::WrongShape},
      {"/odom:\n  x..y: 1", 2, ToleranceFault::WrongPath},
      {"/odom:\n  x: -1", 2, ToleranceFault::WrongValue},
      {"/odom:\n  x: much", 2, ToleranceFault::WrongValue},
      {"/odom:\n  x: .inf", 2, ToleranceFault::WrongValue},
      {"/odom:\n  x: {ignore: perhaps}", 2, ToleranceFault::WrongValue},
  };
  for (const auto& [yaml, line, fault] : cases) {
    const auto parsed = Tolerances::parse(yaml, "tolerances.yaml");
    ASSERT_FALSE(parsed) << yaml;
    EXPECT_EQ(parsed.error().where, Place("tolerances.yaml", line)) << yaml;
    EXPECT_EQ(parsed.error().code, ProblemCode{fault}) << yaml;
  }
  EXPECT_TRUE(Tolerances::parse("", "empty.yaml"));
}

TEST(Tolerances, lead_to_fields_of_the_type) {
  const auto all = tolerances("/odom:\n  pose.covariance[*]: 1\n  pose.pose.positon.x: 1\n");
  const auto checked = all.check("/odom", Odometry::message_type());
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().where, Place("tolerances.yaml", 3));
  EXPECT_NE(checked.error().text().find("did you mean 'position'?"), std::string::npos);
  EXPECT_TRUE(all.check("/scan", LaserScan::message_type()));
}

template <typename Message>
std::optional<ValueDifference> compare(const Message& a, const Message& b, const char* yaml = "") {
  const Tolerances allowed = tolerances(yaml);
  MessageDiff diff{Message::message_type(), allowed.of_topic("/topic")};
  return diff.compare(&a, &b);
}

TEST(MessageDiff, finds_the_first_difference_with_its_path) {
  Odometry a, b;
  EXPECT_FALSE(compare(a, b));
  a.pose.pose.position.y = 1.25;
  b.pose.pose.position.y = 1.5;
  b.twist.twist.linear.x = 9.0;
  const auto found = compare(a, b);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->path, "pose.pose.position.y");
  EXPECT_EQ(found->a, "1.25");
  EXPECT_EQ(found->b, "1.5");
  EXPECT_EQ(compare(a, b, "/topic: {pose: 0.25}")->path, "twist.twist.linear.x");
  EXPECT_EQ(compare(a, b, "/topic: {pose: 0.24}")->path, "pose.pose.position.y");
  EXPECT_FALSE(compare(a, b, "/topic: {pose: {ignore: true}, twist: 10}"));
}

TEST(MessageDiff, compares_times_in_seconds) {
  Odometry a, b;
  a.header.stamp.sec = 4;
  b.header.stamp.sec = 3;
  b.header.stamp.nanosec = 999'000'000;
  const auto found = compare(a, b);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->path, "header.stamp");
  EXPECT_EQ(found->a, "4.000000000 s");
  EXPECT_EQ(found->b, "3.999000000 s");
  EXPECT_FALSE(compare(a, b, "'*': {header.stamp: 0.001}"));
  EXPECT_TRUE(compare(a, b, "'*': {header.stamp: 0.0009}"));
}

TEST(MessageDiff, takes_nan_for_equal_to_nan_only) {
  LaserScan a, b;
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  a.ranges = {nan, infinity, 1.0F};
  b.ranges = {-nan, infinity, 1.0F};
  EXPECT_FALSE(compare(a, b));
  b.ranges[0] = 1.0F;
  EXPECT_EQ(compare(a, b, "/topic: {ranges: 1e300}")->path, "ranges[0]");
  b.ranges = {nan, -infinity, 1.0F};
  EXPECT_EQ(compare(a, b, "/topic: {ranges: 1e300}")->path, "ranges[1]");
  b.ranges = {nan, infinity};
  const auto shorter = compare(a, b, "/topic: {ranges: 1e300}");
  ASSERT_TRUE(shorter);
  EXPECT_EQ(shorter->path + ": " + shorter->a + ", " + shorter->b, "ranges: 3 elements, 2 elements");
  EXPECT_FALSE(compare(a, b, "/topic: {ranges: {ignore: true}}"));
}

TEST(MessageDiff, subtracts_large_integers_without_overflow) {
  std_msgs::msg::Int64 a, b;
  a.data = std::numeric_limits<std::int64_t>::min();
  b.data = std::numeric_limits<std::int64_t>::max();
  MessageDiff diff{std_msgs::msg::Int64::message_type(), {}};
  EXPECT_TRUE(diff.compare(&a, &b));
  EXPECT_EQ(diff.fields().at("data").largest, std::pow(2.0, 64));
  b.data = a.data + 1;
  EXPECT_TRUE(compare(a, b)) << "as doubles they are equal";
  EXPECT_FALSE(compare(a, b, "/topic: {data: 1}"));
}

TEST(MessageDiff, counts_each_field_and_keeps_its_largest_difference) {
  LaserScan a, b;
  a.ranges = b.ranges = {1.0F, 2.0F, 3.0F};
  b.ranges[1] = 2.25F;
  MessageDiff diff{LaserScan::message_type(), {}};
  EXPECT_TRUE(diff.compare(&a, &b));
  EXPECT_FALSE(diff.compare(&a, &a));
  b.ranges[2] = 2.0F;
  b.header.frame_id = "laser";
  EXPECT_TRUE(diff.compare(&a, &b));
  ASSERT_EQ(diff.fields().size(), 2U);
  const FieldDifference& ranges = diff.fields().at("ranges[*]");
  EXPECT_EQ(ranges.values, 3U);
  EXPECT_TRUE(ranges.is_number);
  EXPECT_EQ(ranges.largest, 1.0);
  EXPECT_EQ(ranges.path, "ranges[2]");
  EXPECT_EQ(ranges.round, 2U);
  EXPECT_FALSE(diff.fields().at("header.frame_id").is_number);
}

TEST(MessageDiff, shows_of_long_texts_where_they_differ) {
  std_msgs::msg::String a, b;
  a.data = std::string(1000, 'x') + "left" + std::string(1000, 'y');
  b.data = std::string(1000, 'x') + "right" + std::string(1000, 'y');
  const auto found = compare(a, b);
  ASSERT_TRUE(found);
  EXPECT_NE(found->a.find("xleftyy"), std::string::npos);
  EXPECT_NE(found->b.find("xrightyy"), std::string::npos);
  EXPECT_LT(found->a.size(), 80U);
}

/// A recording of Strings, each said at a time in s.
class Talk {
 public:
  explicit Talk(std::uint64_t begin) : begin_(begin), writer_(file_, {.chunk_bytes = 200}) {
    EXPECT_TRUE(writer_.start());
    EXPECT_TRUE(writer_.add_schema("std_msgs/msg/String", "ros2msg", "string data\n"));
  }
  void say(const std::string& topic, double at, const std::string& words) {
    const auto channel = writer_.add_channel(1, topic, "cdr", {});
    std_msgs::msg::String message;
    message.data = words;
    const Bytes bytes = msgs::to_cdr(message);
    const auto time = begin_ + static_cast<std::uint64_t>(at * 1e9);
    EXPECT_TRUE(channel && writer_.write({*channel, 0, time, time, {bytes}}));
    ++topics_[topic].messages;
    topics_[topic].type = "std_msgs/msg/String";
  }
  std::unique_ptr<OrderedMessages> messages() {
    EXPECT_TRUE(writer_.finish());
    auto opened = OrderedMessages::open({&file_});
    EXPECT_TRUE(opened);
    return std::move(*opened);
  }
  [[nodiscard]] RecordingDiff::Topic topic(const std::string& name) const {
    const auto found = topics_.find(name);
    return found == topics_.end() ? RecordingDiff::Topic{} : found->second;
  }

 private:
  const std::uint64_t begin_;
  MemoryFile file_;
  McapWriter writer_;
  std::map<std::string, RecordingDiff::Topic> topics_;
};

std::vector<TopicDiff> diff_of(Talk& a, Talk& b, const std::vector<std::string>& topics, bool is_known = true) {
  const Tolerances none;
  RecordingDiff diff{none, [&](const std::string& name) -> const msgs::MessageType* {
                       EXPECT_EQ(name, "std_msgs/msg/String");
                       return is_known ? &std_msgs::msg::String::message_type() : nullptr;
                     }};
  for (const auto& topic : topics) EXPECT_TRUE(diff.add_topic(topic, a.topic(topic), b.topic(topic)));
  const auto of_a = a.messages(), of_b = b.messages();
  diff.run(*of_a, *of_b);
  return diff.topics();
}

TEST(RecordingDiff, pairs_messages_by_their_order_whatever_their_times) {
  Talk a{100 * kNsPerS}, b{900 * kNsPerS};
  for (int i = 0; i < 50; ++i) {
    a.say("/left", 0.1 * i, "word " + std::to_string(i));
    b.say("/left", 0.3 * i, "word " + std::to_string(i));
  }
  for (int i = 0; i < 50; ++i) a.say("/right", 0.1 * i, std::to_string(i));
  for (int i = 0; i < 50; ++i) b.say("/right", 0.02 * i, i == 30 ? "other" : std::to_string(i));
  const auto topics = diff_of(a, b, {"/left", "/right"});
  ASSERT_EQ(topics.size(), 2U);
  EXPECT_TRUE(topics[0].is_equal());
  EXPECT_EQ(topics[0].equal, 50U);
  EXPECT_FALSE(topics[1].is_equal());
  EXPECT_EQ(topics[1].equal, 49U);
  ASSERT_TRUE(topics[1].first);
  EXPECT_EQ(topics[1].first->number, 30U);
  EXPECT_EQ(topics[1].first->time_a, 103 * kNsPerS);
  EXPECT_EQ(topics[1].first->value.a, "'30'");
  EXPECT_EQ(topics[1].first->value.b, "'other'");
  EXPECT_EQ(topics[1].fields.at("data").round, 30U) << "pairs of equal bytes count, too";
}

TEST(RecordingDiff, reports_another_number_of_messages_and_a_missing_topic) {
  Talk a{1}, b{1};
  for (int i = 0; i < 3; ++i) a.say("/both", i, "same");
  b.say("/both", 0, "same");
  b.say("/only", 0, "same");
  const auto topics = diff_of(a, b, {"/both", "/only"});
  ASSERT_EQ(topics.size(), 2U);
  EXPECT_EQ(topics[0].in_a, 3U);
  EXPECT_EQ(topics[0].in_b, 1U);
  EXPECT_EQ(topics[0].equal, 1U);
  EXPECT_EQ(topics[0].different, 0U);
  EXPECT_FALSE(topics[0].is_equal());
  EXPECT_EQ(topics[1].type_a, "");
  EXPECT_EQ(topics[1].in_b, 1U);
  EXPECT_FALSE(topics[1].is_equal());
}

TEST(RecordingDiff, compares_bytes_of_a_type_that_is_not_installed) {
  Talk a{1}, b{1};
  a.say("/secret", 0, "same");
  b.say("/secret", 0, "same");
  a.say("/secret", 1, "cat");
  b.say("/secret", 1, "cut");
  const auto topics = diff_of(a, b, {"/secret"}, false);
  EXPECT_NE(topics[0].remark.find("the type is not installed"), std::string::npos);
  EXPECT_EQ(topics[0].equal, 1U);
  ASSERT_TRUE(topics[0].first);
  EXPECT_EQ(topics[0].first->value.path, "byte 9");
  EXPECT_EQ(topics[0].first->value.a, "0x61");
  EXPECT_EQ(topics[0].first->value.b, "0x75");
}

TEST(RecordingDiff, does_not_decode_what_was_recorded_with_another_definition) {
  const Tolerances none;
  RecordingDiff diff{none, [](const std::string&) { return &std_msgs::msg::String::message_type(); }};
  const std::string own = std_msgs::msg::String::message_type().hash;
  ASSERT_TRUE(diff.add_topic("/same", {"std_msgs/msg/String", own, 1}, {"std_msgs/msg/String", "", 1}));
  ASSERT_TRUE(diff.add_topic("/other", {"std_msgs/msg/String", own, 1}, {"std_msgs/msg/String", "RIHS01_00", 1}));
  EXPECT_NE(diff.topics()[0].remark.find("another definition"), std::string::npos);
  EXPECT_EQ(diff.topics()[1].remark, "");
}

}  // namespace
}  // namespace nacelle::record
