// SPDX-License-Identifier: Apache-2.0
#include "look/protocol/client_message.hpp"

#include <gtest/gtest.h>

#include "look/protocol/look_fault.hpp"

namespace nacelle::look {
namespace {

template <typename Message>
Message taken(std::string_view text) {
  auto read = read_text(text);
  EXPECT_TRUE(read) << read.error().text();
  return std::get<Message>(*read);
}

std::string fault_of(std::string_view text) {
  const auto read = read_text(text);
  return read ? "" : read.error().code.text();
}

// The texts are those of the protocol's specification.
TEST(ClientMessage, subscriptions_have_the_viewers_number_and_the_channels) {
  const auto message = taken<Subscribe>(
      R"({"op": "subscribe", "subscriptions": [{"id": 0, "channelId": 3}, {"id": 1, "channelId": 5}]})");
  ASSERT_EQ(message.all.size(), 2U);
  EXPECT_EQ(message.all[1].subscription, 1U);
  EXPECT_EQ(message.all[1].channel, 5U);
  EXPECT_EQ(taken<Unsubscribe>(R"({"op": "unsubscribe", "subscriptionIds": [0, 4294967295]})").subscriptions,
            (std::vector<std::uint32_t>{0, 4294967295}));
}

TEST(ClientMessage, topics_that_a_viewer_publishes) {
  const auto message = taken<Advertise>(R"({"op": "advertise", "channels": [{"id": 2, "topic": "/tf", "encoding": "cdr",
      "schemaName": "tf2_msgs/msg/TFMessage", "schema": "", "schemaEncoding": "ros2msg"}]})");
  ASSERT_EQ(message.all.size(), 1U);
  EXPECT_EQ(message.all[0].channel, 2U);
  EXPECT_EQ(message.all[0].topic, "/tf");
  EXPECT_EQ(message.all[0].encoding, "cdr");
  EXPECT_EQ(message.all[0].type, "tf2_msgs/msg/TFMessage");
  EXPECT_EQ(taken<Unadvertise>(R"({"op": "unadvertise", "channelIds": [1, 2]})").channels.size(), 2U);
}

TEST(ClientMessage, parameters_and_the_rest) {
  const auto get = taken<GetParameters>(R"({"op": "getParameters", "parameterNames": ["/a.b"], "id": "q1"})");
  EXPECT_EQ(get.names, std::vector<std::string>{"/a.b"});
  EXPECT_EQ(get.id, "q1");
  EXPECT_EQ(taken<GetParameters>(R"({"op": "getParameters", "parameterNames": []})").id, "");
  const auto set = taken<SetParameters>(
      R"({"op": "setParameters", "parameters": [{"name": "/a.b", "value": 3, "type": "float64"}, {"name": "/a.c"}]})");
  ASSERT_EQ(set.all.size(), 2U);
  EXPECT_EQ(set.all[0].type, "float64");
  EXPECT_EQ(set.all[0].value, 3);
  EXPECT_TRUE(set.all[1].value.is_null());
  EXPECT_TRUE(taken<WatchParameters>(R"({"op": "subscribeParameterUpdates", "parameterNames": ["/a.b"]})").on);
  EXPECT_FALSE(taken<WatchParameters>(R"({"op": "unsubscribeParameterUpdates", "parameterNames": []})").on);
  EXPECT_TRUE(taken<WatchGraph>(R"({"op": "subscribeConnectionGraph"})").on);
  EXPECT_FALSE(taken<WatchGraph>(R"({"op": "unsubscribeConnectionGraph"})").on);
  const auto fetch = taken<FetchAsset>(R"({"op": "fetchAsset", "uri": "package://a/b.stl", "requestId": 7})");
  EXPECT_EQ(fetch.uri, "package://a/b.stl");
  EXPECT_EQ(fetch.request, 7U);
}

TEST(ClientMessage, what_is_no_message_is_named) {
  for (const char* const text :
       {"", "{", "[]", "{}", R"({"op": 1})", R"({"op": "fly"})", R"({"op": "subscribe"})",
        R"({"op": "subscribe", "subscriptions": 1})", R"({"op": "subscribe", "subscriptions": [1]})",
        R"({"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 1}]})",
        R"({"op": "subscribe", "subscriptions": [{"id": 4294967296, "channelId": 1}]})",
        R"({"op": "subscribe", "subscriptions": [{"id": 1.5, "channelId": 1}]})",
        R"({"op": "advertise", "channels": [{"id": 1, "topic": "/t"}]})",
        R"({"op": "advertise", "channels": [{"id": 1, "topic": 5, "encoding": "cdr", "schemaName": "x"}]})",
        R"({"op": "getParameters", "parameterNames": [1]})", R"({"op": "setParameters", "parameters": ["x"]})",
        R"({"op": "fetchAsset", "uri": "x"})"}) {
    EXPECT_EQ(fault_of(text), code_text(LookFault::BadMessage)) << text;
  }
  std::string many = R"({"op": "unsubscribe", "subscriptionIds": [0)";
  for (int i = 0; i < 1000; ++i) many += ",0";
  EXPECT_EQ(fault_of(many + "]}"), code_text(LookFault::TooMany));
}

TEST(ClientMessage, binary_frames_are_messages_and_calls) {
  const Bytes message{1, 2, 0, 0, 1, 0xAA, 0xBB};
  const auto published = read_binary(message);
  ASSERT_TRUE(published);
  EXPECT_EQ(std::get<Publication>(*published).channel, 0x01000002U);
  EXPECT_EQ(std::get<Publication>(*published).data.size(), 2U);
  const Bytes frame{2, 7, 0, 0, 0, 9, 0, 0, 0, 3, 0, 0, 0, 'c', 'd', 'r', 0xCC};
  const auto read = read_binary(frame);
  ASSERT_TRUE(read);
  const auto& call = std::get<ServiceCall>(*read);
  EXPECT_EQ(call.service, 7U);
  EXPECT_EQ(call.call, 9U);
  EXPECT_EQ(call.encoding, "cdr");
  ASSERT_EQ(call.data.size(), 1U);
  EXPECT_EQ(call.data[0], 0xCC);
  for (const Bytes& wrong : {Bytes{}, Bytes{9}, Bytes{1, 0, 0, 0}, Bytes{2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
                             Bytes{2, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 0, 0, 'c', 'd', 'r'},
                             Bytes{2, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255}}) {
    const auto none = read_binary(wrong);
    ASSERT_FALSE(none) << to_hex(wrong);
    EXPECT_EQ(none.error().code.text(), code_text(LookFault::BadMessage));
  }
}

}  // namespace
}  // namespace nacelle::look
