// SPDX-License-Identifier: Apache-2.0
#include "remote/graph_rows.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "nacelle/msgs/message_type.hpp"
#include "transport_dds/wire/graph_snapshot.hpp"
#include "transport_dds/wire/user_data.hpp"

namespace nacelle::remote {
namespace {

using nlohmann::json;
using transport_dds::DiscoveredEndpoint;
using transport_dds::Gid;
using transport_dds::RemoteGraph;

Gid participant(std::uint8_t number) {
  Gid gid;
  gid.bytes[0] = number;
  return gid.participant();
}
Gid end_of(const Gid& participant, std::uint8_t number, bool is_writer) {
  Gid gid = participant;
  gid.bytes[12] = gid.bytes[13] = 0;
  gid.bytes[14] = number;
  gid.bytes[15] = is_writer ? 3 : 4;
  return gid;
}

/// A node that publishes a topic and offers two services, a lifecycle node's and one of its own; and a stranger that reads.
struct Rows : ::testing::Test {
  Rows() {
    const std::string user_data = transport_dds::write_participant_user_data();
    graph.participant_is_there({robot, Bytes(user_data.begin(), user_data.end()), "nacelle", "far", "17"});
    add(robot, 1, true, "rt/scan", "sensor_msgs::msg::dds_::LaserScan_");
    add(robot, 2, false, "rq/lidar/get_stateRequest", "lifecycle_msgs::srv::dds_::GetState_Request_");
    add(robot, 3, true, "rr/lidar/get_stateReply", "lifecycle_msgs::srv::dds_::GetState_Response_");
    add(robot, 4, false, "rq/lidar/spinRequest", "std_srvs::srv::dds_::SetBool_Request_");
    add(robot, 5, true, "rr/lidar/spinReply", "std_srvs::srv::dds_::SetBool_Response_");
    add(stranger, 1, false, "rt/scan", "sensor_msgs::msg::dds_::LaserScan_");
    transport_dds::GraphSnapshot snapshot{robot};
    snapshot.add_node("/", "lidar");
    for (const std::uint8_t number : {1, 3, 5})
      EXPECT_TRUE(snapshot.add_endpoint("/", "lidar", end_of(robot, number, true), true));
    for (const std::uint8_t number : {2, 4})
      EXPECT_TRUE(snapshot.add_endpoint("/", "lidar", end_of(robot, number, false), false));
    graph.snapshot_came(end_of(robot, 9, true), msgs::to_cdr(snapshot.message()));
  }
  void add(const Gid& whose, std::uint8_t number, bool is_writer, const char* topic, const char* type) {
    DiscoveredEndpoint end;
    end.gid = end_of(whose, number, is_writer);
    end.participant = whose;
    end.is_writer = is_writer;
    end.topic = topic;
    end.type = type;
    graph.endpoint_is_there(end);
  }
  const Gid robot = participant(1), stranger = participant(2);
  RemoteGraph graph{participant(7)};
};

TEST_F(Rows, shows_whether_a_node_has_a_lifecycle_and_parameters) {
  const json nodes = graph_rows(graph)["nodes"];

  ASSERT_EQ(nodes.size(), 1U) << nodes;
  EXPECT_EQ(nodes[0]["node"], "/lidar");
  EXPECT_EQ(nodes[0]["managed"], true);
  EXPECT_EQ(nodes[0]["parameters"], false);
  EXPECT_EQ(nodes[0]["hidden"], false);
  EXPECT_EQ(nodes[0]["host"], "far");
}

TEST_F(Rows, an_end_without_a_node_has_ros_2s_words_for_that) {
  const json ends = graph_rows(graph)["endpoints"];

  ASSERT_EQ(ends.size(), 2U) << ends;
  EXPECT_EQ(ends[0]["node"], "/lidar");
  EXPECT_EQ(ends[0]["publisher"], true);
  EXPECT_EQ(ends[0]["gid"], "01.00.00.00.00.00.00.00.00.00.00.00.00.00.01.03");
  EXPECT_EQ(ends[1]["node"], "_NODE_NAMESPACE_UNKNOWN_/_NODE_NAME_UNKNOWN_");
}

TEST_F(Rows, a_service_stands_once_for_its_four_ends) {
  const json services = graph_rows(graph)["services"];

  ASSERT_EQ(services.size(), 2U) << services;
  EXPECT_EQ(services[0]["name"], "/lidar/get_state");
  EXPECT_EQ(services[0]["type"], "lifecycle_msgs/srv/GetState");
  EXPECT_EQ(services[0]["standard"], true);
  EXPECT_EQ(services[1]["name"], "/lidar/spin");
  EXPECT_EQ(services[1]["server"], true);
  EXPECT_EQ(services[1]["standard"], false);
}

TEST_F(Rows, a_topic_is_counted_by_type_and_side) {
  EXPECT_EQ(topic_rows(graph),
            json::parse(R"([{"name": "/scan", "type": "sensor_msgs/msg/LaserScan", "writers": 1, "readers": 1}])"));
}

}  // namespace
}  // namespace nacelle::remote
