// SPDX-License-Identifier: Apache-2.0
#include "nacelle/qos/yaml_tree.hpp"

#include <gtest/gtest.h>

#include <random>

namespace nacelle {
namespace {

TEST(YamlTree, keeps_lines_order_and_quotes) {
  const auto root = parse_yaml("a: 1\nb:\n  - 'x'\n  - y\na: !!str 2\n", "f.yaml");
  ASSERT_TRUE(root);
  ASSERT_EQ(root->items.size(), 3U);
  EXPECT_EQ(root->items[0].key, "a");
  EXPECT_EQ(root->items[1].key_line, 2);
  EXPECT_TRUE(root->items[1].items[0].quoted);
  EXPECT_EQ(root->items[1].items[1].line, 4);
  EXPECT_FALSE(root->items[1].items[1].quoted);
  EXPECT_EQ(root->items[2].tag, "str");
  EXPECT_EQ(root->find("a")->text, "2");
  EXPECT_EQ(root->find("c"), nullptr);
}

TEST(YamlTree, takes_an_empty_document_as_null) {
  for (const char* text : {"", "\n", "# only a comment\n", "---\n", "~"}) {
    const auto root = parse_yaml(text, "f");
    ASSERT_TRUE(root) << text;
    EXPECT_TRUE(root->is_null()) << text;
  }
}

TEST(YamlTree, says_where_the_syntax_is_broken) {
  const auto broken = parse_yaml("a: 1\nb: [1, 2\nc: 3\n", "f.yaml");
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().where.file, "f.yaml") << broken.error().text();
}

TEST(YamlTree, says_that_a_list_or_a_map_is_not_closed) {
  EXPECT_EQ(parse_yaml("[1", "f").error().text(), "f:1: this is not YAML: end of sequence flow not found (column 1)");
  EXPECT_EQ(parse_yaml("{a: {", "f").error().text(), "f:1: this is not YAML: end of map flow not found (column 1)");
  EXPECT_EQ(parse_yaml("a: 1\nb: [1,\n  2\n", "f").error().where.text(), "f:4");
  EXPECT_EQ(parse_yaml("{[1]: 2}", "f").error().what, "a key must be text, not a list or a map");
  for (const char* const text : {"a:\n  b: 1\n\tc: 2\n", "a:\n  b:\n\tc: x\n", "a:\n  b:\n\tc: x\n\td: y\n"}) {
    EXPECT_EQ(parse_yaml(text, "f.yaml").error().text(),
              "f.yaml:3: this is not YAML: a tab indents the line (column 1); indent with spaces");
  }
  EXPECT_TRUE(parse_yaml("a: [1,\n\t2]\nb:\t3\n", "f"));
  EXPECT_EQ(parse_yaml("a: [1,\n\t2\nb: 3\n", "f").error().what.find("tab"), std::string::npos);
}

TEST(YamlTree, refuses_what_multiplies_or_nests_without_end) {
  EXPECT_EQ(parse_yaml("a: &x 1\nb: 2", "f").error().where.text(), "f:1");
  EXPECT_FALSE(parse_yaml("a: *x", "f"));
  EXPECT_FALSE(parse_yaml("a: 1\n---\nb: 2\n", "f"));
  EXPECT_FALSE(parse_yaml("? [a, b]\n: 1", "f"));
  for (const char* unit : {"[", "{a: ", "- ", "{? ", "[a, {b: "}) {
    std::string deep;
    for (int i = 0; i < 100000; ++i) deep += unit;
    EXPECT_EQ(parse_yaml(deep, "f").error().what, "more than 64 levels of nesting") << unit;
  }
  EXPECT_FALSE(parse_yaml(std::string(kMaxYamlBytes + 1, ' '), "f"));
}

TEST(YamlTree, survives_any_bytes) {
  std::mt19937 random{42};
  const std::string alphabet = "ab01:-[]{},'\"\n\n  #&*!|>%@`?~\t\x01\xff";
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    const std::size_t length = random() % 60;
    for (std::size_t k = 0; k < length; ++k) text += alphabet[random() % alphabet.size()];
    const auto root = parse_yaml(text, "f");
    if (!root) { EXPECT_FALSE(root.error().text().empty()); }
  }
}

}  // namespace
}  // namespace nacelle
