// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/names.hpp"

#include <gtest/gtest.h>

#include <random>

namespace nacelle {
namespace {

TEST(TopicNames, expand_as_rcl_does) {
  EXPECT_EQ(expand_topic_name("/abs/x", "n", "/ns").value(), "/abs/x");
  EXPECT_EQ(expand_topic_name("x", "n", "/ns").value(), "/ns/x");
  EXPECT_EQ(expand_topic_name("x/y", "n", "/").value(), "/x/y");
  EXPECT_EQ(expand_topic_name("~/x", "n", "/ns").value(), "/ns/n/x");
  EXPECT_EQ(expand_topic_name("~/x", "n", "/").value(), "/n/x");
  EXPECT_EQ(expand_topic_name("~", "n", "/ns").value(), "/ns/n");
  EXPECT_EQ(expand_topic_name("{node}/x", "n", "/ns").value(), "/ns/n/x");
  EXPECT_EQ(expand_topic_name("{ns}/x", "n", "/ns").value(), "/ns/x");
  EXPECT_EQ(expand_topic_name("/other/{namespace}", "n", "/").error().text().find("'/other//'") != std::string::npos,
            true);
}

TEST(TopicNames, are_refused_with_the_reason) {
  const std::pair<const char*, const char*> cases[]{
      {"", "empty"},        {"a/", "end with '/'"}, {"1a", "digit"},        {"a/2b", "digit"},
      {"a b", "letters"},   {"a~", "first"},        {"~a", "after '~'"},    {"{nod}/x", "{'nod'}"},
      {"{node", "without"}, {"a-b", "letters"},     {"{node}}", "letters"}, {"/", "end with '/'"},
  };
  for (const auto& [name, why] : cases) {
    const auto refused = validate_topic_name(name);
    ASSERT_FALSE(refused) << name;
    EXPECT_NE(refused.error().text().find(why), std::string::npos) << name << ": " << refused.error().text();
  }
  EXPECT_FALSE(expand_topic_name("a//b", "n", "/"));
  EXPECT_FALSE(expand_topic_name("a", "n n", "/"));
  EXPECT_FALSE(expand_topic_name("a", "n", "ns"));
  EXPECT_FALSE(expand_topic_name(std::string(247, 'a'), "n", "/"));
  EXPECT_TRUE(expand_topic_name(std::string(246, 'a'), "n", "/"));
}

TEST(TopicNames, an_expanded_name_is_always_valid_and_expands_to_itself) {
  std::mt19937 random{11};
  const std::string alphabet = "ab1_/~{}nodes";
  int valid = 0;
  for (int i = 0; i < 50000; ++i) {
    std::string name;
    const std::size_t length = 1 + random() % 8;
    for (std::size_t k = 0; k < length; ++k) name += alphabet[random() % alphabet.size()];
    const auto full = expand_topic_name(name, "node", "/ns");
    if (!full) continue;
    ++valid;
    EXPECT_TRUE(validate_full_topic_name(*full)) << name;
    EXPECT_EQ(expand_topic_name(*full, "other", "/").value(), *full) << name;
  }
  EXPECT_GT(valid, 1000);
}

TEST(NodeNames, allow_words_only) {
  EXPECT_TRUE(validate_node_name("lidar_2"));
  for (const char* name : {"", "2lidar", "li-dar", "a/b", "a.b", "\x1b[0m"})
    EXPECT_FALSE(validate_node_name(name)) << name;
  EXPECT_FALSE(validate_node_name(std::string(256, 'a')));
  EXPECT_EQ(validate_node_name("\x1b[0m").error().text().find('\x1b'), std::string::npos);
}

TEST(Namespaces, are_absolute_and_join) {
  EXPECT_TRUE(validate_namespace("/"));
  EXPECT_TRUE(validate_namespace("/a/b"));
  for (const char* name : {"", "a", "/a/", "//", "/1"}) EXPECT_FALSE(validate_namespace(name)) << name;
  EXPECT_EQ(join_namespaces("/", "a"), "/a");
  EXPECT_EQ(join_namespaces("/a", "b/"), "/a/b");
  EXPECT_EQ(join_namespaces("/a", "/b"), "/b");
  EXPECT_EQ(join_namespaces("", ""), "/");
  EXPECT_EQ(fully_qualified_node_name("/", "n"), "/n");
  EXPECT_EQ(fully_qualified_node_name("/a", "n"), "/a/n");
}

TEST(RemapRules, are_read_in_every_form) {
  EXPECT_EQ(parse_remap_rule("a:=b").value(), (RemapRule{RemapKind::TopicOrService, "", "a", "b"}));
  EXPECT_EQ(parse_remap_rule("rostopic://~/a:=/b").value(), (RemapRule{RemapKind::Topic, "", "~/a", "/b"}));
  EXPECT_EQ(parse_remap_rule("cam:rosservice://a:=b").value(), (RemapRule{RemapKind::Service, "cam", "a", "b"}));
  EXPECT_EQ(parse_remap_rule("__name:=n").value(), (RemapRule{RemapKind::NodeName, "", "", "n"}));
  EXPECT_EQ(parse_remap_rule("cam:__ns:=/left").value(), (RemapRule{RemapKind::Namespace, "cam", "", "/left"}));
  for (const char* text :
       {"a=b", "a:=", ":=b", "a:=b*", "*:=b", "__ns:=left", "__node:=a/b", "2:a:=b", "a:=b:=c", "a:=\\1"}) {
    EXPECT_FALSE(parse_remap_rule(text)) << text;
  }
  for (const char* text : {"a:=b", "rostopic://~/a:=/b", "cam:rosservice://a:=b", "cam:__ns:=/left", "__node:=n"}) {
    EXPECT_EQ(to_text(parse_remap_rule(text).value()), text);
  }
}

TEST(Remapping, takes_the_first_rule_that_matches_and_no_second) {
  const std::vector<RemapRule> rules{
      parse_remap_rule("other:scan:=/wrong").value(), parse_remap_rule("rosservice://scan:=/s").value(),
      parse_remap_rule("scan:=~/front").value(), parse_remap_rule("scan:=/never").value(),
      parse_remap_rule("/ns/lidar/front:=/chained").value()};
  const RemapContext lidar{"lidar", "/ns", {}};
  EXPECT_EQ(remap_topic("/ns/scan", rules, lidar).value(), "/ns/lidar/front");
  EXPECT_EQ(remap_service("/ns/scan", rules, lidar).value(), "/s");
  EXPECT_EQ(remap_topic("/scan", rules, lidar).value(), "/scan");
  EXPECT_EQ(remap_topic("/ns/scan", rules, RemapContext{"lidar", "/ns", "other"}).value(), "/wrong");
}

TEST(Remapping, renames_nodes_and_namespaces) {
  const std::vector<RemapRule> rules{parse_remap_rule("a:__node:=b").value(), parse_remap_rule("__ns:=/x").value()};
  EXPECT_EQ(remap_node_name("a", rules), "b");
  EXPECT_EQ(remap_node_name("c", rules), "c");
  EXPECT_EQ(remap_namespace("/", "a", rules), "/x");
}

}  // namespace
}  // namespace nacelle
