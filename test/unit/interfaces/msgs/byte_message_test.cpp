// SPDX-License-Identifier: Apache-2.0
#include "nacelle/msgs/byte_message.hpp"

#include <gtest/gtest.h>

#include "nacelle/msgs/any_message.hpp"

namespace nacelle::msgs {
namespace {

const Bytes kSome{0, 1, 0, 3, 7, 0, 0, 0, 'a', 0, 0, 0};

TEST(ByteMessage, gives_back_what_it_has_read) {
  const ByteMessageType bytes{"acme_msgs/msg/Secret", "acme_msgs::msg::dds_::Secret_", "RIHS01_00"};
  AnyMessage message{bytes.type()};

  ASSERT_TRUE(bytes.type().decode(kSome, message.get()));

  EXPECT_EQ(message.encoded(), kSome);
  EXPECT_STREQ(bytes.type().name, "acme_msgs/msg/Secret");
  EXPECT_STREQ(bytes.type().dds_name, "acme_msgs::msg::dds_::Secret_");
  EXPECT_STREQ(bytes.type().hash, "RIHS01_00");
  EXPECT_TRUE(is_byte_type(bytes.type()));
}

TEST(ByteMessage, is_copied_and_moved_as_a_message_is) {
  const ByteMessageType bytes{"a", "b", ""};
  AnyMessage first{bytes.type()}, second{bytes.type()}, third{bytes.type()};
  ASSERT_TRUE(bytes.type().decode(kSome, first.get()));

  bytes.type().copy_assign(second.get(), first.get());
  bytes.type().move_assign(third.get(), first.get());

  EXPECT_EQ(second.encoded(), kSome);
  EXPECT_EQ(third.encoded(), kSome);
}

TEST(ByteMessage, lasts_with_its_definition) {
  const MessageType* const type = lasting_byte_type("acme_msgs/msg/Secret", "d", "h", "int32 x\n");
  ASSERT_NE(type, nullptr);
  EXPECT_STREQ(type->definition, "int32 x\n");
  EXPECT_EQ(lasting_byte_type("acme_msgs/msg/Secret", "d", "h", "int32 x\n"), type);
  EXPECT_NE(lasting_byte_type("acme_msgs/msg/Secret", "d", "h", ""), type);
}

TEST(ByteMessage, are_not_more_than_others_may_ask_for) {
  int made = 0;
  for (int i = 0; i < 2000; ++i) made += lasting_byte_type("n" + std::to_string(i), "", "", "") != nullptr ? 1 : 0;
  EXPECT_GT(made, 900);
  EXPECT_LE(made, 1000);
}

}  // namespace
}  // namespace nacelle::msgs
