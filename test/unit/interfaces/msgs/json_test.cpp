// SPDX-License-Identifier: Apache-2.0
#include "msgs_test_support.hpp"

#include <my_robot_msgs/msg/nothing.hpp>
#include <my_robot_msgs/msg/odds.hpp>
#include <my_robot_msgs/msg/shape.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sensor_msgs/msg/image.hpp>

#include "nacelle/msgs/utf16.hpp"

namespace nacelle {
namespace {

using msgs::MessageFault;
using my_robot_msgs::msg::Odds;
using my_robot_msgs::msg::Shape;
using testing::AllOf;
using testing::HasSubstr;

template <typename Message>
Result<void, Problem> read(const std::string& text, Message& message) {
  return msgs::from_json(text, Message::message_type(), &message);
}
template <typename Message>
Problem problem_of(const std::string& text) {
  Message message;
  const auto done = read(text, message);
  EXPECT_FALSE(done) << text;
  return done ? Problem{} : done.error();
}
template <typename Message>
std::string refusal(const std::string& text) {
  return problem_of<Message>(text).text();
}
/// The text is refused with this code; `where` is the path of the field, `value` what stands there.
template <typename Message>
void expect_refusal(const std::string& text, MessageFault code, const std::string& where, const std::string& value) {
  const Problem problem = problem_of<Message>(text);
  EXPECT_EQ(problem.code.text(), code_text(code)) << problem.text();
  EXPECT_EQ(problem.where.text(), where) << problem.text();
  EXPECT_EQ(problem.value, value) << problem.text();
}

TEST(Json, of_every_golden_message_comes_back_to_the_same_bytes) {
  for (const auto& vector : test::golden_vectors()) {
    const auto& type = test::message_type(vector.type);
    msgs::AnyMessage first{type};
    ASSERT_TRUE(type.decode(vector.bytes, first.get()));
    msgs::AnyMessage second{type};
    const auto done = msgs::from_json(test::to_json(first), type, second.get());
    ASSERT_TRUE(done) << done.error().text();
    EXPECT_EQ(to_hex(second.encoded()), to_hex(vector.bytes)) << vector.type << " " << vector.sample;
  }
}

TEST(Json, has_the_fields_in_the_definitions_order_on_one_line) {
  sensor_msgs::msg::Image image;
  image.data = {1, 255};
  EXPECT_EQ(
      msgs::to_json(image),
      R"({"header":{"stamp":{"sec":0,"nanosec":0},"frame_id":""},"height":0,"width":0,"encoding":"","is_bigendian":0,)"
      R"("step":0,"data":[1,255]})");
}

TEST(Json, of_an_empty_message_is_an_empty_object) {
  my_robot_msgs::msg::Nothing nothing;
  EXPECT_EQ(msgs::to_json(nothing), "{}");
  EXPECT_TRUE(read("{}", nothing));
}

TEST(Json, without_a_field_gives_the_definitions_default) {
  Odds odds;
  odds.tenth = 7.0;
  odds.name = "other";
  odds.bytes = {9};
  ASSERT_TRUE(read("{}", odds));
  EXPECT_EQ(odds.tenth, 0.1);
  EXPECT_EQ(odds.name, Odds{}.name);
  EXPECT_EQ(odds.bytes, (Buffer<std::uint8_t>{1, 2, 255}));
}

TEST(Json, gives_elements_their_own_defaults) {
  Shape shape;
  ASSERT_TRUE(read(R"({"labels":[{},{"text":"x"}]})", shape));
  ASSERT_EQ(shape.labels.size(), 2U);
  EXPECT_EQ(shape.labels[0].text, my_robot_msgs::msg::Label{}.text);
  EXPECT_EQ(shape.labels[1].weights.size(), 8U);
}

TEST(Json, writes_and_reads_numbers_that_are_not_finite_as_texts) {
  Odds odds;
  ASSERT_TRUE(read(R"({"not_a_number":"Infinity","minus_infinity":"NaN","tenth":"-Infinity"})", odds));
  EXPECT_EQ(odds.not_a_number, std::numeric_limits<float>::infinity());
  EXPECT_TRUE(std::isnan(odds.minus_infinity));
  EXPECT_EQ(odds.tenth, -std::numeric_limits<double>::infinity());
  EXPECT_THAT(msgs::to_json(odds), AllOf(HasSubstr(R"("not_a_number":"Infinity")"),
                                         HasSubstr(R"("minus_infinity":"NaN")"), HasSubstr(R"("tenth":"-Infinity")")));
}

TEST(Json, keeps_64_bit_integers_exact) {
  Odds odds;
  ASSERT_TRUE(read(R"({"int":-9223372036854775807,"message_type":18446744073709551614})", odds));
  EXPECT_EQ(odds.int_, -9223372036854775807LL);
  EXPECT_EQ(odds.message_type_, 18446744073709551614ULL);
  EXPECT_THAT(msgs::to_json(odds),
              AllOf(HasSubstr("\"int\":-9223372036854775807"), HasSubstr("\"message_type\":18446744073709551614")));
}

TEST(Json, keeps_every_float_exact) {
  Odds odds;
  for (const double value : {0.1, 1e-300, 5e-324, 1.7976931348623157e308, -0.0, 123456789.125}) {
    odds.tenth = value;
    odds.not_a_number = static_cast<float>(value);
    if (std::isinf(odds.not_a_number)) odds.not_a_number = std::numeric_limits<float>::max();
    const float single = odds.not_a_number;
    Odds back;
    ASSERT_TRUE(read(msgs::to_json(odds), back)) << value;
    EXPECT_EQ(std::signbit(back.tenth), std::signbit(value));
    EXPECT_EQ(back.tenth, value);
    EXPECT_EQ(back.not_a_number, single);
  }
}

TEST(Json, keeps_texts_of_any_language) {
  Odds odds;
  odds.name = "\"\\\n\tgr\u00fc\u00df \U0001F600";
  odds.wide = u"gr\u00fc\u00df \U0001F600";
  Odds back;
  const auto done = read(msgs::to_json(odds), back);
  ASSERT_TRUE(done) << done.error().text();
  EXPECT_EQ(back.name, odds.name);
  EXPECT_EQ(back.wide, odds.wide);
}

TEST(Json, of_a_text_that_is_no_utf8_is_still_json) {
  Odds odds;
  odds.name = "a\xFF";
  odds.wide = {u'a', char16_t{0xD800}};
  const auto json = nlohmann::json::parse(msgs::to_json(odds));
  EXPECT_EQ(json.at("name"), "a\uFFFD");
  EXPECT_EQ(json.at("wide"), "a\uFFFD");
}

TEST(WideText, replaces_what_is_not_utf8_or_utf16) {
  EXPECT_EQ(msgs::utf16_of("a\xFFz"), u"a\uFFFDz");
  EXPECT_EQ(msgs::utf16_of("a\xF0\x9F\x98"), u"a\uFFFD") << "cut off within a character";
  EXPECT_EQ(msgs::utf16_of("\xF0\x9F\x98\x80"), u"\U0001F600");
  EXPECT_EQ(msgs::utf8_of(std::u16string{0xDC00, u'a', 0xD800, 0xD83D, 0xDE00}), "\uFFFDa\uFFFD\U0001F600");
}

TEST(FromJson, refuses_an_unknown_field_and_names_its_path) {
  expect_refusal<Shape>(R"({"header":{"stamp":{"secs":1}}})", MessageFault::UnknownField, "header.stamp.secs", "secs");
  expect_refusal<Shape>(R"({"images":[{},{"hight":1}]})", MessageFault::UnknownField, "images[1].hight", "hight");
  expect_refusal<my_robot_msgs::msg::Nothing>(R"({"x":1})", MessageFault::UnknownField, "x", "x");
}

TEST(FromJson, refuses_what_does_not_fit_with_code_path_and_value) {
  using enum MessageFault;
  expect_refusal<Odds>(R"({"new":128})", OutOfRange, "new", "128");
  expect_refusal<Odds>(R"({"default":-1})", OutOfRange, "default", "-1");
  expect_refusal<Odds>(R"({"default":1.5})", OutOfRange, "default", "1.5");
  expect_refusal<Odds>(R"({"int":9223372036854775808})", OutOfRange, "int", "9223372036854775808");
  EXPECT_EQ(problem_of<Odds>(R"({"message_type":18446744073709551616})").code, OutOfRange);
  EXPECT_EQ(problem_of<Odds>(R"({"not_a_number":1e39})").code, OutOfRange);
  expect_refusal<Odds>(R"({"tenth":"nan"})", WrongType, "tenth", "\"nan\"");
  expect_refusal<Odds>(R"({"class":1})", WrongType, "class", "1");
  expect_refusal<Odds>(R"({"name":null})", WrongType, "name", "null");
  expect_refusal<Odds>(R"({"bytes":[1,256]})", OutOfRange, "bytes[1]", "256");
  expect_refusal<Odds>(R"({"triple":[1,2]})", WrongLength, "triple", "[1,2]");
  expect_refusal<Odds>(R"({"few":[1,2,3,4,5]})", WrongLength, "few", "[1,2,3,4,5]");
  expect_refusal<Odds>(R"({"short_name":"ninechars"})", WrongLength, "short_name", "\"ninechars\"");
  expect_refusal<Odds>(R"({"flags":true})", WrongType, "flags", "true");
  expect_refusal<Shape>(R"({"corners":[{},{},{},7]})", WrongType, "corners[3]", "7");
}

TEST(FromJson, refuses_text_that_is_no_json_and_fields_given_twice) {
  for (const char* text : {"", "{", "nonsense", "{\"name\":\"\xFF\"}", R"({"tenth":1e999})"})
    EXPECT_EQ(problem_of<Odds>(text).code, MessageFault::Malformed) << text;
  for (const char* text : {"[]", "1"}) EXPECT_EQ(problem_of<Odds>(text).code, MessageFault::WrongType) << text;
  expect_refusal<Odds>(R"({"tenth":1,"tenth":2})", MessageFault::Twice, "my_robot_msgs/msg/Odds", "tenth");
}

TEST(FromJson, refuses_text_that_is_nested_without_end) {
  const std::size_t depth = 200000;
  EXPECT_EQ(problem_of<Odds>(std::string(depth, '[') + std::string(depth, ']')).code, MessageFault::Malformed);
  std::string objects;
  for (std::size_t i = 0; i < depth; ++i) objects += "{\"a\":";
  EXPECT_EQ(problem_of<Odds>(objects + "1" + std::string(depth, '}')).code, MessageFault::Malformed);
}

TEST(FromJson, has_these_words) {
  EXPECT_EQ(refusal<Shape>(R"({"header":{"stamp":{"secs":1}}})"),
            "header.stamp.secs: there is no such field in builtin_interfaces/msg/Time; did you mean 'sec'?");
  EXPECT_EQ(refusal<my_robot_msgs::msg::Nothing>(R"({"x":1})"),
            "x: there is no such field in my_robot_msgs/msg/Nothing; it has no fields");
  EXPECT_THAT(refusal<Odds>(R"({"new":128})"), HasSubstr("new: 128 is not a whole number from -128 to 127 (int8)"));
  EXPECT_EQ(refusal<Odds>(R"({"name":null})"), "name: null is not a string");
  EXPECT_EQ(refusal<Odds>(R"({"triple":[1,2]})"), "triple: [1,2] is not an array of 3 (it has 2)");
  EXPECT_THAT(refusal<Odds>(R"({"tenth":1,"tenth":2})"), HasSubstr("the field \"tenth\" is given twice"));
  EXPECT_THAT(refusal<Odds>(std::string(200000, '[') + std::string(200000, ']')), HasSubstr("deeper"));
}

TEST(FromJson, leaves_the_message_alone_when_it_fails) {
  Odds odds;
  odds.tenth = 42.0;
  EXPECT_FALSE(read(R"({"tenth":1.0,"new":1000})", odds));
  EXPECT_EQ(odds.tenth, 42.0);
}

}  // namespace
}  // namespace nacelle
