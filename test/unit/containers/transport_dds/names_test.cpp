// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/names.hpp"

#include <gtest/gtest.h>

#include <set>

#include "recordings.hpp"

namespace nacelle::transport_dds {
namespace {

std::string dds_again(const RosName& name) {
  switch (name.kind) {
    case WireKind::Topic: return dds_topic_name(name.name).value();
    case WireKind::Request: return dds_request_name(name.name).value();
    case WireKind::Reply: return dds_reply_name(name.name).value();
    case WireKind::Discovery: return std::string(kDiscoveryTopic);
    case WireKind::Foreign: break;
  }
  return {};
}

TEST(Names, of_everything_that_ros_2_announced_go_there_and_back) {
  std::set<WireKind> kinds;
  for (const auto& endpoint : recorded::announcements()) {
    const RosName name = ros_name(endpoint.topic);
    EXPECT_EQ(dds_again(name), endpoint.topic);
    const auto type = ros_type_name(endpoint.type);
    ASSERT_TRUE(type) << endpoint.type;
    EXPECT_EQ(dds_type_name(*type).value(), endpoint.type);
    const bool is_service = name.kind == WireKind::Request || name.kind == WireKind::Reply;
    EXPECT_EQ(service_of_half(*type).has_value(), is_service) << endpoint.type;
    kinds.insert(name.kind);
  }
  EXPECT_EQ(kinds, (std::set{WireKind::Topic, WireKind::Request, WireKind::Reply, WireKind::Discovery}));
}

TEST(Names, are_those_that_ros_2_uses) {
  EXPECT_EQ(dds_topic_name("/chatter").value(), "rt/chatter");
  EXPECT_EQ(dds_request_name("/n/s").value(), "rq/n/sRequest");
  EXPECT_EQ(dds_reply_name("/n/s").value(), "rr/n/sReply");
  EXPECT_EQ(dds_topic_name("/fib/_action/feedback").value(), "rt/fib/_action/feedback");
  EXPECT_EQ(dds_request_name("/fib/_action/send_goal").value(), "rq/fib/_action/send_goalRequest");
  EXPECT_EQ(dds_topic_name(service_event_topic("/n/s")).value(), "rt/n/s/_service_event");
  EXPECT_EQ(dds_type_name("sensor_msgs/msg/Image").value(), "sensor_msgs::msg::dds_::Image_");
  EXPECT_EQ(dds_type_name("nav2_msgs/action/NavigateToPose_SendGoal_Request").value(),
            "nav2_msgs::action::dds_::NavigateToPose_SendGoal_Request_");
}

TEST(Names, without_ros_conventions_have_no_prefix_and_keep_the_suffix) {
  EXPECT_EQ(dds_topic_name("Square", true).value(), "Square");
  EXPECT_EQ(dds_request_name("/s", true).value(), "/sRequest");
  EXPECT_EQ(dds_reply_name("/s", true).value(), "/sReply");
  EXPECT_FALSE(dds_topic_name("", true));
}

TEST(Names, that_ros_2_does_not_allow_are_refused_with_the_reason) {
  EXPECT_FALSE(dds_topic_name(""));
  EXPECT_FALSE(dds_topic_name("chatter"));
  EXPECT_FALSE(dds_topic_name("/a//b"));
  EXPECT_FALSE(dds_topic_name("/a/"));
  EXPECT_NE(dds_topic_name("/a/3d").error().what.find("digit"), std::string::npos);
  EXPECT_FALSE(dds_type_name("Image dds_"));
  EXPECT_FALSE(dds_type_name(""));
  EXPECT_FALSE(dds_type_name("sensor_msgs//Image"));
  EXPECT_FALSE(dds_type_name("a/dds_/B"));
}

TEST(Names, fill_ddss_255_bytes_and_no_more) {
  const auto name = [](std::size_t bytes) { return "/" + std::string(bytes - 1, 'a'); };

  EXPECT_EQ(dds_topic_name(name(247)).value().size(), 249U);
  EXPECT_FALSE(dds_topic_name(name(248)));
  EXPECT_EQ(dds_request_name(name(246)).value().size(), kMaxDdsNameBytes);
  EXPECT_NE(dds_request_name(name(247)).error().what.find("256 bytes"), std::string::npos);
  EXPECT_EQ(dds_topic_name(name(255), true).value().size(), kMaxDdsNameBytes);
  EXPECT_FALSE(dds_topic_name(name(256), true));
  EXPECT_FALSE(dds_type_name("a/msg/" + std::string(250, 'A')));
}

TEST(Names, of_strangers_have_no_meaning_in_ros_2) {
  for (const char* topic :
       {"", "r", "rt", "rt/", "rtx/a", "rq/s", "rq/Request", "rqRequest", "rr/sRequest", "rr/sReplyX", "Square",
        "DCPSParticipant", "rt/a b", "rt/\x1b[2J", "rt//a", "rt/a/", "ros_discovery_info2", "rp/s", "ra/s"}) {
    EXPECT_EQ(ros_name(topic), RosName{}) << topic;
  }
  EXPECT_EQ(ros_name("rt/" + std::string(300, 'a')), RosName{});
  EXPECT_EQ(ros_name("rt/_hidden"), (RosName{WireKind::Topic, "/_hidden"}));
  EXPECT_EQ(ros_name("rq/sRequestRequest"), (RosName{WireKind::Request, "/sRequest"}));
}

TEST(Names, of_types_of_strangers_have_no_meaning_in_ros_2) {
  for (const char* type : {"", "_", "Square", "dds_::", "dds_::_", "std_msgs::msg::dds_::String",
                           "std_msgs::msg::String_", "std_msgs:msg::dds_::String_", "::msg::dds_::String_",
                           "a::dds_::B::C_", "a::dds_::\x1b[2J_", "3d::dds_::A_", "mydds_::A_"}) {
    EXPECT_EQ(ros_type_name(type), std::nullopt) << type;
  }
  EXPECT_EQ(ros_type_name("dds_::Plain_"), "Plain");
  EXPECT_EQ(ros_type_name("a::b::c::dds_::D_"), "a/b/c/D");
}

TEST(Names, of_service_types_come_from_either_half) {
  EXPECT_EQ(service_of_half("std_srvs/srv/SetBool_Request"), "std_srvs/srv/SetBool");
  EXPECT_EQ(service_of_half("std_srvs/srv/SetBool_Response"), "std_srvs/srv/SetBool");
  EXPECT_EQ(service_of_half("nav2_msgs/action/Wait_GetResult_Response"), "nav2_msgs/action/Wait_GetResult");
  EXPECT_EQ(service_of_half("std_srvs/srv/SetBool_Event"), std::nullopt);
  EXPECT_EQ(service_of_half("_Request"), std::nullopt);
}

}  // namespace
}  // namespace nacelle::transport_dds
