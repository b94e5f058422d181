// SPDX-License-Identifier: Apache-2.0
#include "look/component/parameter_json.hpp"

#include <gtest/gtest.h>

#include "look/component/parameter_questions.hpp"
#include "nacelle/base/json_text.hpp"

namespace nacelle::look {
namespace {

using nlohmann::json;

json there_and_back(const json& value, const std::string& type = "") {
  const auto read = parameter_value(value, type);
  EXPECT_TRUE(read) << value;
  return read ? parameter_json("/n.p", *read) : json{};
}

TEST(ParameterJson, values_of_every_type_come_back_as_they_were) {
  for (const json& value : {json(true), json(-5), json("text"), json({1, 2}), json({"a", "b"}), json({true, false})})
    EXPECT_EQ(there_and_back(value), (json{{"name", "/n.p"}, {"value", value}}));
  EXPECT_EQ(there_and_back(3, "float64"), (json{{"name", "/n.p"}, {"value", 3.0}, {"type", "float64"}}));
  EXPECT_EQ(there_and_back(2.5), (json{{"name", "/n.p"}, {"value", 2.5}, {"type", "float64"}}));
  EXPECT_EQ(there_and_back({1, 2}, "float64_array")["type"], "float64_array");
  EXPECT_EQ(there_and_back({1.5, 2})["value"], json({1.5, 2.0}));
  EXPECT_EQ(there_and_back(nullptr), (json{{"name", "/n.p"}}));
}

// RFC 4648, section 10
TEST(ParameterJson, bytes_are_base64) {
  for (const auto& [bytes, text] : std::initializer_list<std::pair<std::string, std::string>>{{"", ""},
                                                                                              {"f", "Zg=="},
                                                                                              {"fo", "Zm8="},
                                                                                              {"foo", "Zm9v"},
                                                                                              {"foob", "Zm9vYg=="},
                                                                                              {"fooba", "Zm9vYmE="},
                                                                                              {"foobar", "Zm9vYmFy"}}) {
    const auto read = parameter_value(text, "byte_array");
    ASSERT_TRUE(read) << text;
    EXPECT_EQ(std::string(read->byte_array_value.begin(), read->byte_array_value.end()), bytes);
    EXPECT_EQ(parameter_json("p", *read)["value"], text);
  }
  EXPECT_FALSE(parameter_value("Z", "byte_array"));
  EXPECT_FALSE(parameter_value("Zg*=", "byte_array"));
  EXPECT_FALSE(parameter_value(5, "byte_array"));
}

TEST(ParameterJson, other_json_is_no_value) {
  for (const char* const text : {"{}", R"([1, "a"])", "[[]]", "[true, 1]"})
    EXPECT_FALSE(parameter_value(parse_json_or_discard(text), "")) << text;
  EXPECT_FALSE(parameter_value(parse_json_or_discard(R"(["a"])"), "float64_array"));
}

TEST(ParameterName, is_split_at_the_first_dot) {
  EXPECT_EQ(parameter_name("/ns/node.a.b").node, "/ns/node");
  EXPECT_EQ(parameter_name("/ns/node.a.b").parameter, "a.b");
  EXPECT_EQ(parameter_name("/node").parameter, "");
}

}  // namespace
}  // namespace nacelle::look
