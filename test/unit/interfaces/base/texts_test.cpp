// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tinyxml2.h>

#include "nacelle/base/json_text.hpp"
#include "nacelle/base/nesting.hpp"
#include "nacelle/base/printable.hpp"
#include "nacelle/base/xml.hpp"

namespace nacelle {
namespace {

using ::testing::HasSubstr;

std::string repeated(std::size_t times, const std::string& text) {
  std::string all;
  for (std::size_t i = 0; i < times; ++i) all += text;
  return all;
}

std::string xml_problem(const std::string& text) {
  tinyxml2::XMLDocument document;
  const auto parsed = parse_xml(document, text, "a.xml");
  return parsed ? "ok" : parsed.error().text();
}

constexpr std::string_view kHostile =
    "a\x1b[2J\r\x7f\xc2\x9b"
    "b\tc\nd \xc3\xa9\n";

TEST(Printable, escapes_control_characters_and_keeps_letters) {
  EXPECT_EQ(printable(kHostile), "a\\x1b[2J\\x0d\\x7f\\xc2\\x9bb\tc\nd \xc3\xa9\n");
  EXPECT_EQ(printable_line(kHostile), "a\\x1b[2J\\x0d\\x7f\\xc2\\x9bb\\x09c\\x0ad \xc3\xa9\\x0a");
  EXPECT_EQ(printable_entry(kHostile), "a\\x1b[2J\\x0d\\x7f\\xc2\\x9bb\tc\n  | d \xc3\xa9");
}

TEST(Printable, keeps_text_without_control_characters) {
  for (const std::string text : {"", "base_link", "\xc3\xa9t\xc3\xa9 \xc2\xa0 \xc2"}) {
    EXPECT_TRUE(is_printable_line(text));
    for (const auto& shown : {printable(text), printable_line(text), printable_entry(text)}) EXPECT_EQ(shown, text);
  }
  for (const char* const text : {"\n", "\t", "\x1b", "\x7f", "\xc2\x80"}) EXPECT_FALSE(is_printable_line(text));
}

TEST(Printable, a_suggestion_is_one_line_whatever_the_names_are) {
  EXPECT_EQ(suggestion("base_lnk\n", {"base_link\n"}), "did you mean 'base_link\\x0a'?");
  EXPECT_EQ(suggestion("x", {"base_link\n", "odometry"}), "one of base_link\\x0a, odometry");
}

TEST(JsonText, reads_values_as_deep_as_the_limit_and_no_deeper) {
  constexpr std::size_t kMost = kMostNesting;

  EXPECT_TRUE(parse_json(repeated(kMost, "[") + repeated(kMost, "]")));
  EXPECT_TRUE(parse_json(repeated(kMost - 1, "{\"a\":") + "{}" + repeated(kMost - 1, "}")));
  EXPECT_EQ(parse_json(repeated(kMost + 1, "[") + repeated(kMost + 1, "]")).error().text(),
            "line 1: lists and objects are nested deeper than 64 levels");
  EXPECT_EQ(parse_json("\n\n" + repeated(200'000, "{\"a\":")).error().where.text(), "line 3");
  EXPECT_TRUE(parse_json_or_discard(repeated(200'000, "[")).is_discarded());
}

TEST(JsonText, does_not_count_brackets_in_strings_and_those_side_by_side) {
  EXPECT_TRUE(parse_json("[\"" + repeated(100, "[{\\\"\\\\") + "\"]"));
  EXPECT_TRUE(parse_json("[" + repeated(1000, "[],") + "[]]"));
}

TEST(JsonText, says_what_is_wrong_without_the_name_of_the_parser) {
  const auto parsed = parse_json("{\"a\": }");

  EXPECT_THAT(parsed.error().text(), HasSubstr("this is not JSON: parse error at line 1"));
  EXPECT_THAT(parsed.error().text(), ::testing::Not(HasSubstr("json.exception")));
}

TEST(XmlText, says_what_is_wrong_with_the_line_in_words_of_its_own) {
  EXPECT_EQ(xml_problem("<a/>"), "ok");
  EXPECT_EQ(xml_problem("<r>\n<a>\n</r>"),
            "a.xml:2: the element <a> that begins here is not closed by its own </...>; close it");
  EXPECT_EQ(xml_problem(""), "a.xml: this is not XML: there is no element in it");
  EXPECT_EQ(xml_problem("<!-- nothing -->"), "a.xml: this is not XML: there is no element in it");
  EXPECT_EQ(xml_problem("<a>\n<b c='1></a>"),
            "a.xml:2: this is not XML: an attribute is not complete, or stands twice; write name=\"value\"");
  EXPECT_EQ(xml_problem("<a><!-- b</a>"), "a.xml:1: this is not XML: a comment does not end; end it with -->");
}

TEST(XmlText, bounds_the_depth_while_parsing) {
  constexpr std::size_t kMost = kMostNesting;
  const std::string deepest = repeated(kMost - 1, "<a>") + "<b/>\n<c/>" + repeated(kMost - 1, "</a>");

  EXPECT_EQ(xml_problem(deepest), "ok");
  EXPECT_EQ(xml_problem("<r>\n" + deepest + "</r>"), "a.xml:2: the elements are nested deeper than 64 levels");
  EXPECT_EQ(xml_problem("<r>" + repeated(1000, "<a><b/></a>") + "</r>"), "ok");
  EXPECT_EQ(xml_problem(repeated(200'000, "<a>")), "a.xml:1: the elements are nested deeper than 64 levels");
}

}  // namespace
}  // namespace nacelle
