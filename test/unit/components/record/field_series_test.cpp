// SPDX-License-Identifier: Apache-2.0
#include "record/model/field_series.hpp"

#include <gtest/gtest.h>

#include <sensor_msgs/msg/laser_scan.hpp>

#include "record/protocol/mcap_writer.hpp"
#include "seen_file.hpp"

namespace nacelle::record {
namespace {

using sensor_msgs::msg::LaserScan;

TEST(TopicField, is_parsed) {
  EXPECT_EQ(*parse_topic_field("/odom.pose.x"), (TopicField{"/odom", "pose.x"}));
  EXPECT_EQ(*parse_topic_field("left/scan.ranges[3]"), (TopicField{"/left/scan", "ranges[3]"}));
  for (const char* text : {"", "/odom", ".x", "/odom.", "/.x"}) EXPECT_FALSE(parse_topic_field(text)) << text;
}

class FieldSeriesTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(writer_.start());
    ASSERT_EQ(writer_.add_schema("sensor_msgs/msg/LaserScan", "ros2msg", "x"), 1);
    ASSERT_EQ(writer_.add_channel(1, "/scan", "cdr", {}), 1);
    ASSERT_EQ(writer_.add_channel(1, "/silent", "cdr", {}), 2);
    for (const std::uint64_t time : {200U, 100U, 300U}) {  // not in their order
      LaserScan scan;
      scan.angle_min = static_cast<float>(time);
      if (time != 100) scan.ranges = {1.0F, 0.5F * static_cast<float>(time)};
      const Bytes bytes = msgs::to_cdr(scan);
      ASSERT_TRUE(writer_.write({1, 0, time, time, {bytes}}));
    }
    ASSERT_TRUE(writer_.finish());
  }
  std::unique_ptr<FieldSeries> read(const std::vector<TopicField>& fields) {
    auto series =
        std::make_unique<FieldSeries>(fields, [](const std::string& name) -> Result<const msgs::MessageType*, Problem> {
          EXPECT_EQ(name, "sensor_msgs/msg/LaserScan");
          return &LaserScan::message_type();
        });
    EXPECT_TRUE(walk_mcap(file_, *series));
    return series;
  }
  std::string problem_of(const TopicField& field) {
    const auto checked = read({field})->check();
    return checked ? "none" : checked.error().text();
  }

  MemoryFile file_;
  McapWriter writer_{file_, {}};
};

TEST_F(FieldSeriesTest, has_values_in_the_order_of_their_times) {
  const auto series = read({{"/scan", "angle_min"}, {"/scan", "ranges[1]"}});
  ASSERT_TRUE(series->check());
  EXPECT_EQ(series->first(), 100U);
  EXPECT_EQ(series->values(0), (std::vector<TimedValue>{{100, 100.0}, {200, 200.0}, {300, 300.0}}));
  EXPECT_EQ(series->values(1), (std::vector<TimedValue>{{200, 100.0}, {300, 150.0}})) << "one has no such element";
}

TEST_F(FieldSeriesTest, says_why_there_is_nothing_to_draw) {
  EXPECT_NE(problem_of({"/scna", "angle_min"}).find("did you mean '/scan'?"), std::string::npos);
  EXPECT_NE(problem_of({"/scan", "angel_min"}).find("did you mean 'angle_min'?"), std::string::npos);
  EXPECT_NE(problem_of({"/scan", "ranges[7]"}).find("no message has this element"), std::string::npos);
}

TEST_F(FieldSeriesTest, counts_messages_that_cannot_be_decoded_as_problems) {
  FieldSeries series{{{"/scan", "angle_min"}}, [](const std::string&) -> Result<const msgs::MessageType*, Problem> {
                       return &LaserScan::message_type();
                     }};
  series.on_channel({1, 0, "/scan", "cdr", {}});
  const Bytes bytes{0, 1, 0, 0, 1};
  series.on_message({1, 0, 5, 5, {bytes}}, {});
  ASSERT_EQ(series.problems().size(), 1U);
  EXPECT_EQ(series.problems()[0].fault, McapFault::BadPayload);
  EXPECT_FALSE(series.check());
}

TEST(Joined, interpolates_between_two_values) {
  const std::vector<TimedValue> x{{10, 1.0}, {20, 2.0}, {30, 5.0}};
  const std::vector<TimedValue> y{{5, -1.0}, {10, 7.0}, {15, 8.0}, {30, 9.0}, {31, -1.0}};
  EXPECT_EQ(joined(x, y), (std::vector<std::pair<double, double>>{{1.0, 7.0}, {1.5, 8.0}, {5.0, 9.0}}));
  EXPECT_TRUE(joined({}, y).empty());
}

}  // namespace
}  // namespace nacelle::record
