// SPDX-License-Identifier: Apache-2.0
#include "record/model/topic_choice.hpp"

#include <gtest/gtest.h>

namespace nacelle::record {
namespace {

TopicChoice choice(TopicWish wish) {
  auto made = TopicChoice::make(std::move(wish));
  EXPECT_TRUE(made);
  return std::move(made).value();
}

TEST(TopicChoice, takes_nothing_without_a_wish) {
  EXPECT_FALSE(choice({}).is_any());
  EXPECT_FALSE(choice({}).takes("/scan"));
}

TEST(TopicChoice, takes_all_but_hidden_and_excluded_ones) {
  const auto all = choice({.all = true, .exclude_regex = "image", .exclude_topics = {"/tf"}});
  EXPECT_TRUE(all.is_any());
  EXPECT_TRUE(all.takes("/scan"));
  EXPECT_FALSE(all.takes("/camera/image_raw"));
  EXPECT_FALSE(all.takes("/tf"));
  EXPECT_TRUE(all.takes("/tf_static"));
  EXPECT_FALSE(all.takes("/base/_private"));
  EXPECT_TRUE(choice({.all = true, .hidden = true}).takes("/base/_private"));
}

TEST(TopicChoice, takes_named_topics_and_those_that_match) {
  const auto some = choice({.topics = {"/odom", "/base/_private"}, .regex = "^/imu/"});
  EXPECT_TRUE(some.takes("/odom"));
  EXPECT_TRUE(some.takes("/base/_private")) << "it was named";
  EXPECT_TRUE(some.takes("/imu/data"));
  EXPECT_FALSE(some.takes("/front/imu/data"));
  EXPECT_FALSE(some.takes("/odom2"));
}

TEST(TopicChoice, names_a_wrong_expression) {
  const auto wrong = TopicChoice::make({.regex = "(", .exclude_regex = ""});
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().where.text(), "regex");
  EXPECT_EQ(TopicChoice::make({.exclude_regex = "["}).error().where.text(), "exclude_regex");
}

}  // namespace
}  // namespace nacelle::record
