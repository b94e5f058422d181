// SPDX-License-Identifier: Apache-2.0
#include "msgs_test_support.hpp"

#include <my_robot_msgs/msg/nothing.hpp>
#include <my_robot_msgs/msg/odds.hpp>
#include <my_robot_msgs/msg/shape.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sensor_msgs/msg/image.hpp>
#include <std_msgs/msg/string.hpp>
#include <tf2_msgs/msg/tf_message.hpp>

namespace nacelle {
namespace {

using msgs::DecodeFault;
using my_robot_msgs::msg::Odds;

std::string hex(const auto& message) { return to_hex(msgs::to_cdr(message)); }

template <typename Message>
DecodeFault fault_of(const std::string& text) {
  Bytes bytes;
  EXPECT_TRUE(from_hex(text, bytes)) << text;
  Message message;
  const auto decoded = msgs::from_cdr(bytes, message);
  EXPECT_FALSE(decoded) << text;
  return decoded ? DecodeFault{} : decoded.error();
}

/// The same message in big-endian bytes: `widths` lists the values' sizes after the encapsulation, 0 is a byte to keep.
Bytes big_endian(Bytes bytes, const std::vector<std::size_t>& widths) {
  bytes[1] = 0;
  std::size_t at = msgs::kEncapsulationSize;
  for (const std::size_t width : widths) {
    if (width > 1)
      std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                   bytes.begin() + static_cast<std::ptrdiff_t>(at + width));
    at += std::max<std::size_t>(width, 1);
  }
  return bytes;
}

TEST(Cdr, of_a_message_with_every_kind_of_field_comes_back_equal) {
  Odds odds;
  odds.not_a_number = 1.5F;  // NaN is not equal to itself.
  odds.bounded_words = {"a", "", "five5"};
  odds.wide_words = {u"\u00e9", u"", u"abc"};
  odds.pair = {false, true};

  Odds back;
  const auto decoded = msgs::from_cdr(msgs::to_cdr(odds), back);

  ASSERT_TRUE(decoded) << msgs::explain(decoded.error());
  EXPECT_EQ(back, odds);
}

TEST(Cdr, of_nested_arrays_and_sequences_comes_back_equal) {
  my_robot_msgs::msg::Shape shape;
  shape.header.frame_id = "map";
  shape.corners[2].label = "second";
  shape.corners[3].position.z = -1.0;
  shape.more.resize(3);
  shape.more[1].count = 65535;
  shape.few.resize(1);
  shape.outline.resize(5);
  shape.outline[4].y = 0.25;
  shape.ends[1].x = 3.5;
  shape.nothings.resize(2);
  shape.images.resize(2);
  shape.images[1].data = {1, 2, 3};
  shape.labels.resize(1);

  my_robot_msgs::msg::Shape back;
  ASSERT_TRUE(msgs::from_cdr(msgs::to_cdr(shape), back));
  EXPECT_EQ(back, shape);
}

TEST(Cdr, of_an_empty_message_is_one_byte) { EXPECT_EQ(hex(my_robot_msgs::msg::Nothing{}), "0001000000"); }

TEST(Cdr, of_a_wide_text_is_four_bytes_a_unit_without_terminator) {
  Odds odds;
  odds.wide = u"ab";
  EXPECT_THAT(hex(odds), testing::HasSubstr("020000006100000062000000"));
}

TEST(Cdr, of_a_character_beyond_16_bits_is_read_from_one_unit_and_from_two) {
  Odds odds;
  odds.wide = u"\U0001F600";
  const Bytes two_units = msgs::to_cdr(odds);
  std::string one_unit = to_hex(two_units);
  const auto at = one_unit.find("020000003dd8000000de0000");
  ASSERT_NE(at, std::string::npos);
  // One unit instead of two: four bytes less, and everything behind it in this message is aligned to four still.
  one_unit.replace(at, 24, "0100000000f60100");
  Bytes bytes;
  ASSERT_TRUE(from_hex(one_unit, bytes));

  Odds from_one;
  Odds from_two;
  ASSERT_TRUE(msgs::from_cdr(two_units, from_two));
  EXPECT_EQ(from_two.wide, u"\U0001F600");
  (void)msgs::from_cdr(bytes, from_one);  // Fields behind it may be aligned to eight; the text itself has been read.
  EXPECT_EQ(from_one.wide, u"\U0001F600");
}

TEST(Cdr, of_big_endian_peers_is_read) {
  tf2_msgs::msg::TFMessage message;
  message.transforms.resize(1);
  auto& transform = message.transforms[0];
  transform.header.stamp.sec = 1;
  transform.header.stamp.nanosec = 0x01020304;
  transform.header.frame_id = "odom";
  transform.child_frame_id = "base";
  transform.transform.translation.x = 1.25;
  const Bytes little = msgs::to_cdr(message);
  // count, sec, nanosec, length, "odom\0", 3 of padding, length, "base\0"; padding; seven doubles at the end
  std::vector<std::size_t> widths{4, 4, 4, 4, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 0, 0, 0, 0};
  constexpr std::size_t kBeforePadding = 5 * 4 + 5 + 3 + 5;
  widths.resize(widths.size() + little.size() - msgs::kEncapsulationSize - kBeforePadding - 7 * sizeof(double), 0);
  widths.insert(widths.end(), 7, sizeof(double));

  tf2_msgs::msg::TFMessage back;
  const auto decoded = msgs::from_cdr(big_endian(little, widths), back);

  ASSERT_TRUE(decoded) << msgs::explain(decoded.error());
  EXPECT_EQ(back, message);
}

TEST(Decode, accepts_up_to_three_bytes_of_padding) {
  std_msgs::msg::String message;
  for (const char* padding : {"", "00", "0000", "000000"}) {
    Bytes bytes;
    ASSERT_TRUE(from_hex(std::string("00010000060000004865"
                                     "6c6c6f00") +
                             padding,
                         bytes));
    ASSERT_TRUE(msgs::from_cdr(bytes, message));
    EXPECT_EQ(message.data, "Hello");
  }
  EXPECT_EQ(fault_of<std_msgs::msg::String>("000100000600000048656c6c6f0000000000"), DecodeFault::TrailingBytes);
}

TEST(Decode, reads_a_text_of_length_zero_as_empty) {
  Bytes bytes;
  ASSERT_TRUE(from_hex("0001000000000000", bytes));
  std_msgs::msg::String message{"before"};
  ASSERT_TRUE(msgs::from_cdr(bytes, message));
  EXPECT_EQ(message.data, "");
}

TEST(Decode, reads_any_byte_but_zero_as_true) {
  Odds odds;
  Bytes bytes = msgs::to_cdr(odds);
  ASSERT_EQ(bytes[4], 1);
  bytes[4] = 0x80;
  ASSERT_TRUE(msgs::from_cdr(bytes, odds));
  EXPECT_EQ(to_hex(msgs::to_cdr(odds)).substr(8, 2), "01");
}

TEST(Decode, says_why_it_refuses) {
  using std_msgs::msg::String;
  EXPECT_EQ(fault_of<String>(""), DecodeFault::Truncated);
  EXPECT_EQ(fault_of<String>("000100"), DecodeFault::Truncated);
  EXPECT_EQ(fault_of<String>("0003000001000000 00"), DecodeFault::UnknownEncoding);
  EXPECT_EQ(fault_of<String>("0101000001000000 00"), DecodeFault::UnknownEncoding);
  EXPECT_EQ(fault_of<String>("0001000002000000 6161"), DecodeFault::TextNotTerminated);
  EXPECT_EQ(fault_of<String>("0001000003000000 6100"), DecodeFault::Truncated);
}

TEST(Decode, refuses_what_is_longer_than_its_bound) {
  for (const auto& spoil :
       {+[](Odds& odds) { odds.short_name = "ninechars"; }, +[](Odds& odds) { odds.wide_short = u"fives"; },
        +[](Odds& odds) {
          odds.few = {1, 2, 3, 4, 5};
        },
        +[](Odds& odds) {
          odds.bounded_words = {"1", "2", "3", "4"};
        },
        +[](Odds& odds) { odds.bounded_words = {"sixsix"}; }}) {
    Odds odds;
    spoil(odds);
    Odds back;
    const auto decoded = msgs::from_cdr(msgs::to_cdr(odds), back);
    ASSERT_FALSE(decoded);
    EXPECT_EQ(decoded.error(), DecodeFault::BoundExceeded);
  }
}

TEST(Encode, of_a_large_image_is_its_bytes) {
  sensor_msgs::msg::Image image;
  image.data.resize(std::size_t{640} * 480 * 2);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<std::uint8_t>(i);

  const Bytes bytes = msgs::to_cdr(image);

  EXPECT_TRUE(
      std::equal(image.data.begin(), image.data.end(), bytes.end() - static_cast<std::ptrdiff_t>(image.data.size())));
  sensor_msgs::msg::Image back;
  ASSERT_TRUE(msgs::from_cdr(bytes, back));
  EXPECT_EQ(back, image);
}

}  // namespace
}  // namespace nacelle
