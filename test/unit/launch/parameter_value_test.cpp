// SPDX-License-Identifier: Apache-2.0
#include "nacelle/launch/parameter_value.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace nacelle::launch {
namespace {

using Int = std::int64_t;

TEST(ScalarTyping, follows_rcl_yaml_param_parser) {
  for (const char* word : {"Y", "y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"})
    EXPECT_EQ(value_of_scalar(word), ParameterValue(true)) << word;
  for (const char* word : {"N", "n", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"})
    EXPECT_EQ(value_of_scalar(word), ParameterValue(false)) << word;
  EXPECT_EQ(value_of_scalar("42"), ParameterValue(Int{42}));
  EXPECT_EQ(value_of_scalar("-7"), ParameterValue(Int{-7}));
  EXPECT_EQ(value_of_scalar("+7"), ParameterValue(Int{7}));
  EXPECT_EQ(value_of_scalar("0x1F"), ParameterValue(Int{31}));
  EXPECT_EQ(value_of_scalar("-0x10"), ParameterValue(Int{-16}));
  EXPECT_EQ(value_of_scalar("010"), ParameterValue(Int{8}));
  EXPECT_EQ(value_of_scalar("08"), ParameterValue(8.0)) << "no octal number, but one that strtod reads";
  EXPECT_EQ(value_of_scalar("9223372036854775807"), ParameterValue(std::numeric_limits<Int>::max()));
  EXPECT_EQ(value_of_scalar("-9223372036854775808"), ParameterValue(std::numeric_limits<Int>::min()));
  EXPECT_EQ(value_of_scalar("9223372036854775808"), ParameterValue(9223372036854775808.0));
  EXPECT_EQ(value_of_scalar("1.5"), ParameterValue(1.5));
  EXPECT_EQ(value_of_scalar("1e-3"), ParameterValue(1e-3));
  EXPECT_EQ(value_of_scalar(".5"), ParameterValue(0.5));
  EXPECT_EQ(value_of_scalar("-.inf"), ParameterValue(-INFINITY));
  EXPECT_EQ(value_of_scalar("+.INF"), ParameterValue(INFINITY));
  EXPECT_TRUE(std::isnan(std::get<double>(value_of_scalar(".NaN"))));
  for (const char* word :
       {"", "yEs", "tRUE", "1.2.3", "0x", "1e", "abc", "/dev/ttyUSB0", "1 2", "--1", "+-1", "1,5", "12ms"}) {
    EXPECT_EQ(value_of_scalar(word), ParameterValue(std::string(word))) << word;
  }
}

TEST(TextTyping, reads_lists_and_quotes_and_leaves_the_rest_alone) {
  EXPECT_EQ(value_of_text("[1, 2]").value(), ParameterValue(std::vector<Int>{1, 2}));
  EXPECT_EQ(value_of_text("[a, 'b']").value(), ParameterValue(std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(value_of_text("[on, off]").value(), ParameterValue(std::vector<bool>{true, false}));
  EXPECT_EQ(value_of_text("[]").value(), ParameterValue{});
  EXPECT_EQ(value_of_text("'5'").value(), ParameterValue(std::string("5")));
  EXPECT_EQ(value_of_text("[1, 2").value(), ParameterValue(std::string("[1, 2")));
  EXPECT_EQ(value_of_text("a: b").value(), ParameterValue(std::string("a: b")));
  EXPECT_FALSE(value_of_text("[1, 2.0]"));
  EXPECT_FALSE(value_of_text("[1, [2]]"));
  EXPECT_FALSE(value_of_text("['1', 2]"));
}

TEST(ForcedTyping, meets_the_type_or_refuses) {
  EXPECT_EQ(value_of_type("5", ForcedType::Str).value(), ParameterValue(std::string("5")));
  EXPECT_EQ(value_of_type("5", ForcedType::Float).value(), ParameterValue(5.0));
  EXPECT_EQ(value_of_type("0x10", ForcedType::Float).value(), ParameterValue(16.0));
  EXPECT_EQ(value_of_type("yes", ForcedType::Bool).value(), ParameterValue(true));
  EXPECT_EQ(value_of_type("[1, 2]", ForcedType::ListOfFloat).value(), ParameterValue(std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(value_of_type("[1, 2]", ForcedType::ListOfStr).value(), ParameterValue(std::vector<std::string>{"1", "2"}));
  EXPECT_EQ(value_of_type("[]", ForcedType::ListOfInt).value(), ParameterValue(std::vector<Int>{}));
  EXPECT_FALSE(value_of_type("1.5", ForcedType::Int));
  EXPECT_FALSE(value_of_type("5", ForcedType::Bool));
  EXPECT_FALSE(value_of_type("[1, a]", ForcedType::ListOfInt));
  EXPECT_FALSE(value_of_type("5", ForcedType::ListOfInt));
}

TEST(ValueText, reads_back_as_the_same_value) {
  std::vector<ParameterValue> cases{true,
                                    false,
                                    Int{0},
                                    Int{-5},
                                    std::numeric_limits<Int>::min(),
                                    0.0,
                                    -0.1,
                                    1e300,
                                    5.0,
                                    INFINITY,
                                    std::string(),
                                    std::string("5"),
                                    std::string("yes"),
                                    std::string("a: b # c"),
                                    std::string("tab\t\"q\" \\ \n end"),
                                    std::string("[1]"),
                                    std::string("~"),
                                    std::string("null"),
                                    std::string("\xc3\xa9t\xc3\xa9"),
                                    std::string("\xc2\x9b"
                                                "2J"),
                                    std::vector<bool>{true, false},
                                    std::vector<Int>{1, -2},
                                    std::vector<double>{1.0, 2.5},
                                    std::vector<std::string>{"1", "a", "", "x, y"}};
  std::mt19937_64 random{5};
  for (int i = 0; i < 300; ++i) {
    cases.emplace_back(static_cast<Int>(random()));
    std::string text;
    for (std::size_t k = 0; k < random() % 12; ++k) text += static_cast<char>(1 + random() % 126);
    cases.emplace_back(text);
    cases.emplace_back(std::vector<std::string>{text, "b"});
  }
  for (const auto& value : cases) {
    const auto back = value_of_text(to_text(value));
    ASSERT_TRUE(back) << to_text(value);
    EXPECT_EQ(*back, value) << to_text(value);
  }
}

TEST(ParameterValue, as_text_has_no_control_characters) {
  EXPECT_EQ(to_text(std::string("\x1b[2J\n\xc2\x9b")), R"("\x1b[2J\x0a\x9b")");
}

TEST(Assignments, are_name_and_typed_value) {
  const auto speed = parse_parameter_assignment("limits.speed:=0.3");
  ASSERT_TRUE(speed);
  EXPECT_EQ(speed->first, "limits.speed");
  EXPECT_EQ(speed->second, ParameterValue(0.3));
  for (const char* text : {"speed=1", ":=1", "a..b:=1", ".a:=1", "a b:=1", "a\tb:=1", "a\x7f:=1"})
    EXPECT_FALSE(parse_parameter_assignment(text)) << text;
}

TEST(Assignments, accept_names_in_utf_8_whether_or_not_char_has_a_sign) {
  EXPECT_TRUE(parse_parameter_assignment("h\xc3\xb6he:=1"));
}

}  // namespace
}  // namespace nacelle::launch
