// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <std_msgs/msg/string.hpp>

#include "nacelle/runtime/test_container.hpp"

namespace example {

TEST(Talker, publishes_numbered_texts) {
  nacelle::runtime::TestContainer container;
  auto chatter = container.subscribe<std_msgs::msg::String>("/chatter", nacelle::QoS(10));

  container.start("example::Talker", {{"period", 0.01}});

  EXPECT_EQ(chatter.next().data, "hello 1");
  EXPECT_EQ(chatter.next().data, "hello 2");
}

TEST(Talker, refuses_a_period_of_zero) {
  nacelle::runtime::TestContainer container;
  EXPECT_THROW(container.start("example::Talker", {{"period", 0.0}}), std::runtime_error);
}

}  // namespace example
