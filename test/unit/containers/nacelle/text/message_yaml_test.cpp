// SPDX-License-Identifier: Apache-2.0
#include "text/message_yaml.hpp"

#include <gtest/gtest.h>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <limits>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/laser_scan.hpp>
#include <std_msgs/msg/empty.hpp>
#include <std_msgs/msg/string.hpp>

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::text {
namespace {

template <typename T>
std::string yaml(const T& message, YamlOptions options = {}) {
  std::string out;
  append_yaml(out, T::message_type(), &message, options);
  return out;
}

TEST(MessageYaml, looks_as_ros2_topic_echo_does) {
  sensor_msgs::msg::LaserScan scan;
  scan.header.stamp.sec = 3;
  scan.header.stamp.nanosec = 500;
  scan.header.frame_id = "lidar_link";
  scan.range_max = 12;
  scan.ranges = {1.5F, 2.0F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()};
  EXPECT_EQ(yaml(scan), R"(header:
  stamp:
    sec: 3
    nanosec: 500
  frame_id: lidar_link
angle_min: 0.0
angle_max: 0.0
angle_increment: 0.0
time_increment: 0.0
scan_time: 0.0
range_min: 0.0
range_max: 12.0
ranges:
- 1.5
- 2.0
- .inf
- .nan
intensities: []
)");
}

TEST(MessageYaml, cuts_long_sequences_unless_asked_not_to) {
  sensor_msgs::msg::LaserScan scan;
  scan.ranges.resize(1000);
  const auto count = [](const std::string& text) {
    std::size_t n = 0;
    for (std::size_t at = 0; (at = text.find("\n- ", at)) != std::string::npos; ++at) ++n;
    return n;
  };
  EXPECT_EQ(count(yaml(scan)), 129U);
  EXPECT_NE(yaml(scan).find("- '...'\n"), std::string::npos);
  EXPECT_EQ(count(yaml(scan, {0})), 1000U);
}

TEST(MessageYaml, nests_sequences_of_messages) {
  diagnostic_msgs::msg::DiagnosticArray array;
  array.status.resize(1);
  array.status[0].name = "lidar: rate";
  array.status[0].values.resize(2);
  array.status[0].values[0].key = "hz";
  array.status[0].values[0].value = "10";
  array.status[0].values[1].key = "note";
  array.status[0].values[1].value = "it's\nfine";
  EXPECT_EQ(yaml(array), R"(header:
  stamp:
    sec: 0
    nanosec: 0
  frame_id: ''
status:
- level: 0
  name: 'lidar: rate'
  message: ''
  hardware_id: ''
  values:
  - key: hz
    value: '10'
  - key: note
    value: "it's\nfine"
)");
}

TEST(MessageYaml, shows_fixed_arrays_whole) {
  sensor_msgs::msg::Imu imu;
  imu.orientation_covariance[0] = -1;
  const std::string text = yaml(imu);
  EXPECT_NE(text.find("orientation_covariance:\n- -1.0\n- 0.0\n"), std::string::npos) << text;
}

TEST(MessageYaml, escapes_control_characters_in_double_quotes) {
  std_msgs::msg::String message;
  message.data = "a\x1b[2J\n\xc2\x9b \xc3\xa9\"";
  EXPECT_EQ(yaml(message), "data: \"a\\x1b[2J\\n\\x9b \xc3\xa9\\\"\"\n");
}

TEST(MessageYaml, of_an_empty_message_is_an_empty_map) { EXPECT_EQ(yaml(std_msgs::msg::Empty{}), "{}\n"); }

}  // namespace
}  // namespace nacelle::text
