// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "in_memory.hpp"

namespace nacelle::launch {
namespace {

std::string evaluated(const std::string& text, const char* quote = "'") {
  const auto plan = load_plan_text(
      "launch:\n- let: {name: a, value: one}\n- let: {name: empty, value: ''}\n- let: {name: name, value: a}\n- log: "
      "{message: " +
          std::string(quote) + text + quote + "}",
      "dir/f.launch.yaml", {}, in_memory({}, {{"HOME", "/home/me"}}));
  return plan ? plan->messages[0].text : problems_of(plan);
}

TEST(Substitution, replaces_inside_of_text_and_nests) {
  EXPECT_EQ(evaluated("x-$(var a)-$(var a)"), "x-one-one");
  EXPECT_EQ(evaluated("$(var $(var name))"), "one");
  EXPECT_EQ(evaluated("$(env HOME)/x"), "/home/me/x");
  EXPECT_EQ(evaluated("$(env NONE $(var a))"), "one");
  EXPECT_EQ(evaluated("$(env NONE \"two words\")"), "two words");
  EXPECT_EQ(evaluated("$(env NONE \"\")"), "");
  EXPECT_EQ(evaluated("$(env NONE pre$(var a)\" post\")"), "preone post");
  EXPECT_EQ(evaluated("$(dirname)/$(filename)"), "dir/dir/f.launch.yaml");
  EXPECT_EQ(evaluated("$(  var   a  )"), "one");
  EXPECT_EQ(evaluated("$(anon cam) $(anon cam)"), "cam_1 cam_1");
}

TEST(Substitution, leaves_escapes_and_lone_signs_alone) {
  EXPECT_EQ(evaluated("\\$(var a)"), "$(var a)");
  EXPECT_EQ(evaluated("\\\\$(var a)"), "\\one");
  EXPECT_EQ(evaluated("$5 ${x} (y) a\\b"), "$5 ${x} (y) a\\b");
  EXPECT_EQ(evaluated("$(env NONE \"a) b\")"), "a) b");
}

TEST(Substitution, decides) {
  EXPECT_EQ(evaluated("$(not true)"), "false");
  EXPECT_EQ(evaluated("$(and true $(not false))"), "true");
  EXPECT_EQ(evaluated("$(or false 0)"), "false");
  EXPECT_EQ(evaluated("$(equals $(var a) one)"), "true");
  EXPECT_EQ(evaluated("$(equals 1 1.0)"), "true");
  EXPECT_EQ(evaluated("$(equals true True)"), "true");
  EXPECT_EQ(evaluated("$(not-equals a b)"), "true");
  EXPECT_EQ(evaluated("$(equals $(var empty) \"\")"), "true");
}

}  // namespace
}  // namespace nacelle::launch
