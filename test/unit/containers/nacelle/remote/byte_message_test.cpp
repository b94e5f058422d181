// SPDX-License-Identifier: Apache-2.0
#include "remote/byte_message.hpp"

#include <gtest/gtest.h>

#include "nacelle/msgs/any_message.hpp"

namespace nacelle::remote {
namespace {

const Bytes kSome{0, 1, 0, 3, 7, 0, 0, 0, 'a', 0, 0, 0};

TEST(ByteMessage, gives_back_what_it_has_read) {
  const ByteMessageType bytes{"acme_msgs/msg/Secret", "acme_msgs::msg::dds_::Secret_", "RIHS01_00"};
  msgs::AnyMessage message{bytes.type()};

  ASSERT_TRUE(bytes.type().decode(kSome, message.get()));

  EXPECT_EQ(message.encoded(), kSome);
  EXPECT_STREQ(bytes.type().name, "acme_msgs/msg/Secret");
  EXPECT_STREQ(bytes.type().dds_name, "acme_msgs::msg::dds_::Secret_");
  EXPECT_STREQ(bytes.type().hash, "RIHS01_00");
}

TEST(ByteMessage, is_copied_and_moved_as_a_message_is) {
  const ByteMessageType bytes{"a", "b", ""};
  msgs::AnyMessage first{bytes.type()}, second{bytes.type()}, third{bytes.type()};
  ASSERT_TRUE(bytes.type().decode(kSome, first.get()));

  bytes.type().copy_assign(second.get(), first.get());
  bytes.type().move_assign(third.get(), first.get());

  EXPECT_EQ(second.encoded(), kSome);
  EXPECT_EQ(third.encoded(), kSome);
}

}  // namespace
}  // namespace nacelle::remote
