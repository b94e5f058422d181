// SPDX-License-Identifier: Apache-2.0
#include "nacelle/launch/parameter_file.hpp"

#include <gtest/gtest.h>

#include <random>

namespace nacelle::launch {
namespace {

std::string for_node(const std::string& text, const std::string& node) {
  const auto file = parse_parameter_file(text, "p.yaml");
  if (!file) return file.error().front().text();
  std::string all;
  for (const auto& p : file->parameters_for(node))
    all += p.name + "=" + to_text(p.value) + "@" + std::to_string(p.where.line) + " ";
  return all;
}

TEST(ParameterFile, finds_a_node_written_in_any_way) {
  for (const char* key :
       {"/arm/lidar:\n  ros__parameters: {x: 1}", "arm/lidar:\n  ros__parameters: {x: 1}",
        "arm:\n  lidar: {ros__parameters: {x: 1}}", "/arm:\n  /lidar: {ros__parameters: {x: 1}}",
        "/**:\n  ros__parameters: {x: 1}", "'**':\n  ros__parameters: {x: 1}", "/*/lidar:\n  ros__parameters: {x: 1}",
        "/arm/*:\n  ros__parameters: {x: 1}", "/**/lidar:\n  ros__parameters: {x: 1}"}) {
    EXPECT_EQ(for_node(key, "/arm/lidar"), "x=1@2 ") << key;
  }
  for (const char* key : {"lidar", "/arm", "/*", "/arm/lidar/x", "/*/*/*", "/arm/lida"}) {
    EXPECT_EQ(for_node(std::string(key) + ":\n  ros__parameters: {x: 1}", "/arm/lidar"), "") << key;
  }
}

TEST(ParameterFile, takes_dotted_and_nested_names_for_the_same) {
  EXPECT_EQ(for_node("n:\n  ros__parameters:\n    a.b.c: 1\n    a:\n      b: {d: 2}\n      b.c: 3\n", "/n"),
            "a.b.c=3@6 a.b.d=2@5 ");
}

TEST(ParameterFile, lets_the_later_section_win_and_keeps_the_patterns_first_place) {
  EXPECT_EQ(for_node("/**: {ros__parameters: {x: 1}}\nn: {ros__parameters: {x: 2}}", "/n"), "x=2@2 ");
  EXPECT_EQ(for_node("n: {ros__parameters: {x: 2}}\n/**: {ros__parameters: {x: 1}}", "/n"), "x=1@2 ");
  EXPECT_EQ(
      for_node("n: {ros__parameters: {x: 2}}\n/**: {ros__parameters: {x: 1}}\n/n: {ros__parameters: {x: 3, y: 4}}",
               "/n"),
      "x=1@2 y=4@3 ");
}

TEST(ParameterFile, leaves_an_empty_list_unset) {
  EXPECT_EQ(for_node("n: {ros__parameters: {x: [], y: 1}}", "/n"), "y=1@1 ");
}

TEST(ParameterFile, tells_file_and_line_of_every_mistake) {
  const std::pair<const char*, const char*> cases[]{
      {"n:\n  ros__parameters:\n    x:\n", "p.yaml:3: the parameter 'x' has no value; write '' for an empty text"},
      {"n:\n  ros__parameters:\n    x: [1, 2.0]\n",
       "p.yaml:3: the parameter 'x': the list mixes int and double ('2.0'); write all of them as one type, such as 1.0 "
       "instead of 1"},
      {"n:\n  ros__parameters:\n    x: [[1]]\n",
       "p.yaml:3: the parameter 'x': a list may hold only plain values, not a list"},
      {"ros__parameters: {x: 1}", "p.yaml:1: 'ros__parameters' stands below no node; write '/**:' above it"},
      {"n:\n  ros__parameters: 5", "p.yaml:2: 'ros__parameters' needs a map of parameters, not text"},
      {"n-1: {ros__parameters: {x: 1}}",
       "p.yaml:1: 'n-1' is not the name of a node; use letters, digits, '_', '/', and the wildcards * and **"},
      {"n:\n  x: 5\n/**: {ros__parameters: {y: 1}}",
       "p.yaml:2: 'x' is a node or namespace and needs a map, not text; parameters stand below 'ros__parameters'"},
      {"n:\n  ros_parameters: {x: 1}",
       "p.yaml:2: 'ros_parameters' is not part of a node's name; did you mean 'ros__parameters'?"},
      {"n:\n  ros__parameters:\n    x: 1\n    x: 2",
       "p.yaml:4: the key 'x' stands here a second time; the first is at line 3; leave one of them out"},
      {"n:\n  ros__parameters: {x: 1}\nn:\n  ros__parameters: {x: 2}",
       "p.yaml:3: the key 'n' stands here a second time; the first is at line 1; leave one of them out"},
      {"n:\n  ros__parameters: {a: {b: 1, b: 2}}",
       "p.yaml:2: the key 'b' stands here a second time; the first is at line 2; leave one of them out"},
      {"[]", "p.yaml:1: expected a map of nodes, found a list"},
      {"n: {ros__parameters: {a..b: 1}}", "p.yaml:1: the parameter name 'a..b' has an empty part"},
      {"n: {ros__parameters: {x: &a 1}}",
       "p.yaml:1: anchors and aliases are not supported; write the value where it is used"},
  };
  for (const auto& [text, told] : cases) EXPECT_EQ(for_node(text, "/n"), told) << text;
  const auto two = parse_parameter_file("n:\n  ros__parameters:\n    x:\n    y:\n", "p.yaml");
  ASSERT_FALSE(two);
  EXPECT_EQ(two.error().size(), 2U);
}

TEST(NodePatterns, match_as_rcls_regular_expression_does) {
  EXPECT_TRUE(matches_node("/**", "/a"));
  EXPECT_TRUE(matches_node("/**/a/**", "/x/a/y/z"));
  EXPECT_TRUE(matches_node("/**/a/**", "/a"));
  EXPECT_FALSE(matches_node("/**/a/*", "/a"));
  EXPECT_TRUE(matches_node("/*", "/a"));
  EXPECT_FALSE(matches_node("/*", "/a/b"));
  std::string hostile, name;
  for (int i = 0; i < 100; ++i) hostile += "/**/a";
  for (int i = 0; i < 80; ++i) name += "/a";
  EXPECT_FALSE(matches_node(hostile + "/b", name));
}

}  // namespace
}  // namespace nacelle::launch
