// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/remote_graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "nacelle/msgs/message_type.hpp"
#include "nacelle/qos/presets.hpp"
#include "recordings.hpp"

namespace nacelle::transport_dds {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Key;
using ::testing::Pair;

const Gid kUs = recorded::gid("0110fa5e8be4654810e75956000001c1");

// A participant number n and its endpoints.
Gid peer(std::uint8_t n) {
  Gid gid = recorded::gid("01100000000000000000000000000000").participant();
  gid.bytes[2] = n;
  return gid;
}
Gid end(const Gid& participant, std::uint16_t n, bool is_writer) {
  Gid gid = participant;
  gid.bytes[12] = static_cast<std::uint8_t>(n >> 8);
  gid.bytes[13] = static_cast<std::uint8_t>(n);
  gid.bytes[14] = 0;
  gid.bytes[15] = is_writer ? 0x03 : 0x04;
  return gid;
}

DiscoveredParticipant ros_participant(const Gid& gid) {
  const std::string user_data = write_participant_user_data();
  return {gid, Bytes(user_data.begin(), user_data.end()), "talker", "robot", "17"};
}

DiscoveredEndpoint chatter(const Gid& participant, std::uint16_t n, bool is_writer) {
  return {end(participant, n, is_writer), participant, is_writer, "rt/chatter", "std_msgs::msg::dds_::String_", {}, {}};
}

Bytes snapshot_of(const Gid& participant, const std::string& node, const std::vector<Gid>& writers = {}) {
  GraphSnapshot snapshot{participant};
  snapshot.add_node("/", node);
  for (const Gid& gid : writers) EXPECT_TRUE(snapshot.add_endpoint("/", node, gid, true));
  return msgs::to_cdr(snapshot.message());
}

std::vector<std::string> names_of(const RemoteGraph& graph) {
  std::vector<std::string> names;
  for (const auto& node : graph.nodes()) names.push_back(node.node_namespace + " " + node.name);
  return names;
}

// What was seen of one recorded process, its last snapshot included.
RemoteGraph recorded_graph(const std::string& dump, const std::string& samples) {
  RemoteGraph graph{kUs};
  for (const auto& participant : recorded::participants(dump)) graph.participant_is_there(participant);
  for (const auto& endpoint : recorded::endpoints(dump)) graph.endpoint_is_there(endpoint);
  for (const auto& sample : recorded::samples(samples)) {
    if (sample.topic == kDiscoveryTopic) graph.snapshot_came(sample.writer, sample.payload);
  }
  EXPECT_EQ(graph.stats(), RemoteGraphStats{});
  return graph;
}

TEST(RemoteGraph, shows_the_recorded_lifecycle_node_as_ros2_node_info_does) {
  const RemoteGraph graph = recorded_graph("lifecycle", "lc");

  EXPECT_THAT(names_of(graph), ElementsAre("/ lc_talker"));
  EXPECT_EQ(graph.nodes()[0].enclave, "/");
  const auto info = graph.node("/", "lc_talker");
  ASSERT_TRUE(info);
  EXPECT_THAT(info->publishers, Contains(Pair("/rosout", ElementsAre("rcl_interfaces/msg/Log"))));
  EXPECT_THAT(info->publishers, Contains(Pair("/parameter_events", ElementsAre("rcl_interfaces/msg/ParameterEvent"))));
  EXPECT_THAT(info->publishers,
              Contains(Pair("/lc_talker/transition_event", ElementsAre("lifecycle_msgs/msg/TransitionEvent"))));
  EXPECT_THAT(info->subscriptions,
              ElementsAre(Pair("/parameter_events", ElementsAre("rcl_interfaces/msg/ParameterEvent"))));
  EXPECT_EQ(info->servers.size(), 12U);
  EXPECT_THAT(info->servers, Contains(Pair("/lc_talker/change_state", ElementsAre("lifecycle_msgs/srv/ChangeState"))));
  EXPECT_THAT(info->servers, Contains(Pair("/lc_talker/get_transition_graph",
                                           ElementsAre("lifecycle_msgs/srv/GetAvailableTransitions"))));
  EXPECT_THAT(info->clients, IsEmpty());
}

TEST(RemoteGraph, shows_topics_and_services_of_the_recorded_action_server) {
  const RemoteGraph graph = recorded_graph("action", "act");

  EXPECT_THAT(graph.topics(), Contains(Pair("/fib/_action/feedback",
                                            ElementsAre("example_interfaces/action/Fibonacci_FeedbackMessage"))));
  EXPECT_THAT(graph.services(),
              Contains(Pair("/fib/_action/send_goal", ElementsAre("example_interfaces/action/Fibonacci_SendGoal"))));
  const auto info = graph.node("/", "act_server");
  ASSERT_TRUE(info);
  EXPECT_THAT(info->servers, Contains(Key("/fib/_action/cancel_goal")));
  EXPECT_THAT(info->subscriptions, IsEmpty()) << "rclpy reads no parameter_events";
}

TEST(RemoteGraph, shows_each_end_of_a_topic_with_node_type_hash_and_quality) {
  const RemoteGraph graph = recorded_graph("lifecycle", "lc");
  const auto ends = graph.ends_of_topic("/rosout");

  ASSERT_EQ(ends.size(), 1U);
  EXPECT_TRUE(ends[0].is_writer);
  EXPECT_EQ(ends[0].node_name, "lc_talker");
  EXPECT_EQ(ends[0].node_namespace, "/");
  EXPECT_EQ(ends[0].type, "rcl_interfaces/msg/Log");
  EXPECT_EQ(ends[0].user_data.type_hash, "RIHS01_e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac");
  EXPECT_EQ(ends[0].qos, RosoutQoS().resolved());
  EXPECT_THAT(graph.ends_of_topic("/nothing"), IsEmpty());
}

TEST(RemoteGraph, knows_the_two_halves_of_a_server_by_their_id) {
  const RemoteGraph graph = recorded_graph("lifecycle", "lc");
  const auto ends = graph.ends_of_service("/lc_talker/get_state");

  ASSERT_EQ(ends.size(), 2U);
  EXPECT_NE(ends[0].kind, ends[1].kind);
  EXPECT_NE(ends[0].is_writer, ends[1].is_writer);
  EXPECT_FALSE(ends[0].user_data.service_id.empty());
  EXPECT_EQ(ends[0].user_data.service_id, ends[1].user_data.service_id);
  EXPECT_EQ(graph.endpoint(ends[0].gid)->name, "/lc_talker/get_state");
  EXPECT_FALSE(graph.endpoint(kUs));
}

TEST(RemoteGraph, says_unknown_where_no_snapshot_has_the_endpoint) {
  RemoteGraph graph{kUs};
  graph.endpoint_is_there(chatter(peer(1), 6, true));

  EXPECT_EQ(graph.ends_of_topic("/chatter").at(0).node_name, "_NODE_NAME_UNKNOWN_");
  EXPECT_EQ(graph.ends_of_topic("/chatter").at(0).node_namespace, "_NODE_NAMESPACE_UNKNOWN_");
  graph.snapshot_came(end(peer(1), 4, true), snapshot_of(peer(1), "talker", {end(peer(1), 6, true)}));
  EXPECT_EQ(graph.ends_of_topic("/chatter").at(0).node_name, "talker");
}

TEST(RemoteGraph, lists_nodes_of_ros_participants_only_whatever_comes_first) {
  RemoteGraph graph{kUs};
  graph.snapshot_came(end(peer(1), 4, true), snapshot_of(peer(1), "talker"));
  EXPECT_THAT(names_of(graph), IsEmpty());
  EXPECT_FALSE(graph.node("/", "talker"));

  graph.participant_is_there({peer(1), {}, {}, {}, {}});
  EXPECT_THAT(names_of(graph), IsEmpty()) << "no enclave: not of ROS 2";
  graph.participant_is_there(ros_participant(peer(1)));
  EXPECT_THAT(names_of(graph), ElementsAre("/ talker"));
  EXPECT_EQ(graph.nodes()[0].host, "robot");
  EXPECT_EQ(graph.nodes()[0].process, "talker");
}

TEST(RemoteGraph, follows_the_last_snapshot) {
  RemoteGraph graph{kUs};
  graph.participant_is_there(ros_participant(peer(1)));
  graph.snapshot_came(end(peer(1), 4, true), snapshot_of(peer(1), "first"));
  graph.snapshot_came(end(peer(1), 4, true), snapshot_of(peer(1), "second"));
  EXPECT_THAT(names_of(graph), ElementsAre("/ second"));

  graph.snapshot_came(end(peer(1), 4, true), msgs::to_cdr(GraphSnapshot{peer(1)}.message()));
  EXPECT_THAT(names_of(graph), IsEmpty());
}

TEST(RemoteGraph, forgets_all_of_a_participant_that_has_gone_and_nothing_of_others) {
  RemoteGraph graph{kUs};
  for (const std::uint8_t n : {1, 2, 3}) {
    graph.participant_is_there(ros_participant(peer(n)));
    graph.endpoint_is_there(chatter(peer(n), 6, true));
    graph.endpoint_is_there(chatter(peer(n), 7, false));
    graph.snapshot_came(end(peer(n), 4, true), snapshot_of(peer(n), "node" + std::to_string(n)));
  }
  graph.participant_has_gone(peer(2));

  EXPECT_THAT(names_of(graph), ElementsAre("/ node1", "/ node3"));
  EXPECT_EQ(graph.ends_of_topic("/chatter").size(), 4U);
  graph.endpoint_has_gone(end(peer(2), 6, true));  // DDS reports it afterwards, too
  graph.participant_has_gone(peer(2));
  EXPECT_EQ(graph.ends_of_topic("/chatter").size(), 4U);
}

TEST(RemoteGraph, knows_participants_that_have_not_announced_their_endpoints) {
  RemoteGraph graph{kUs};
  EXPECT_FALSE(graph.awaits_endpoints());
  graph.participant_is_there(ros_participant(kUs));
  EXPECT_FALSE(graph.awaits_endpoints()) << "a participant does not wait for its own endpoints";
  graph.participant_is_there(ros_participant(peer(1)));
  graph.participant_is_there(ros_participant(peer(2)));
  EXPECT_TRUE(graph.awaits_endpoints());
  graph.endpoint_is_there(chatter(peer(1), 6, true));
  EXPECT_TRUE(graph.awaits_endpoints());
  DiscoveredEndpoint square = chatter(peer(2), 6, true);
  square.topic = "Square";
  graph.endpoint_is_there(square);
  EXPECT_FALSE(graph.awaits_endpoints()) << "an endpoint that is not of ROS 2 counts, too";
  graph.endpoint_has_gone(end(peer(1), 6, true));
  EXPECT_FALSE(graph.awaits_endpoints()) << "it has nothing any more";
  graph.participant_is_there(ros_participant(peer(3)));
  EXPECT_TRUE(graph.awaits_endpoints());
  graph.participant_has_gone(peer(3));
  EXPECT_FALSE(graph.awaits_endpoints());
}

TEST(RemoteGraph, forgets_an_endpoint_that_has_gone) {
  RemoteGraph graph{kUs};
  graph.endpoint_is_there(chatter(peer(1), 6, true));
  graph.endpoint_has_gone(end(peer(1), 6, true));
  EXPECT_THAT(graph.topics(), IsEmpty());
}

TEST(RemoteGraph, passes_over_what_is_our_own_and_what_is_not_of_ros_2) {
  RemoteGraph graph{kUs};
  graph.participant_is_there(ros_participant(kUs));
  graph.endpoint_is_there(chatter(kUs, 6, true));
  graph.snapshot_came(end(kUs, 4, true), snapshot_of(kUs, "me"));
  DiscoveredEndpoint square = chatter(peer(1), 6, true);
  square.topic = "Square";
  graph.endpoint_is_there(square);

  EXPECT_THAT(names_of(graph), IsEmpty());
  EXPECT_THAT(graph.topics(), IsEmpty());
  EXPECT_EQ(graph.version(), 0U);
  EXPECT_EQ(graph.stats(), RemoteGraphStats{});
}

TEST(RemoteGraph, shows_two_types_of_one_topic) {
  RemoteGraph graph{kUs};
  graph.endpoint_is_there(chatter(peer(1), 6, true));
  DiscoveredEndpoint other = chatter(peer(2), 6, true);
  other.type = "Shape\x1b[31m";
  graph.endpoint_is_there(other);

  EXPECT_THAT(graph.topics(), ElementsAre(Pair("/chatter", ElementsAre("Shape?[31m", "std_msgs/msg/String"))));
}

TEST(RemoteGraph, lists_a_service_that_has_clients_only) {
  RemoteGraph graph{kUs};
  DiscoveredEndpoint reader = chatter(peer(1), 6, false);
  reader.topic = "rr/setReply";
  reader.type = "std_srvs::srv::dds_::SetBool_Response_";
  graph.endpoint_is_there(reader);
  GraphSnapshot snapshot{peer(1)};
  snapshot.add_node("/ns", "asker");
  EXPECT_TRUE(snapshot.add_endpoint("/ns", "asker", reader.gid, false));
  graph.snapshot_came(end(peer(1), 4, true), msgs::to_cdr(snapshot.message()));
  graph.participant_is_there(ros_participant(peer(1)));

  EXPECT_THAT(graph.services(), ElementsAre(Pair("/set", ElementsAre("std_srvs/srv/SetBool"))));
  EXPECT_THAT(graph.node("/ns", "asker")->clients, ElementsAre(Pair("/set", ElementsAre("std_srvs/srv/SetBool"))));
  EXPECT_THAT(graph.node("/ns", "asker")->servers, IsEmpty());
}

TEST(RemoteGraph, tells_by_its_version_that_something_changed) {
  RemoteGraph graph{kUs};
  graph.endpoint_is_there(chatter(peer(1), 6, true));
  const auto before = graph.version();
  graph.endpoint_is_there(chatter(peer(1), 6, true));
  EXPECT_EQ(graph.version(), before) << "announced again, the same";

  DiscoveredEndpoint changed = chatter(peer(1), 6, true);
  changed.qos.depth = 7;
  graph.endpoint_is_there(changed);
  EXPECT_GT(graph.version(), before);
  EXPECT_EQ(graph.ends_of_topic("/chatter").at(0).qos.depth(), 7U);
}

TEST(RemoteGraph, rejects_announcements_for_other_participants) {
  RemoteGraph graph{kUs};
  graph.participant_is_there(ros_participant(peer(1)));
  graph.snapshot_came(end(peer(2), 4, true), snapshot_of(peer(1), "forged"));
  EXPECT_THAT(names_of(graph), IsEmpty());
  EXPECT_EQ(graph.stats().foreign_snapshots, 1U);

  DiscoveredEndpoint forged = chatter(peer(2), 6, true);
  forged.participant = peer(1);
  graph.endpoint_is_there(forged);
  EXPECT_THAT(graph.topics(), IsEmpty());
  EXPECT_EQ(graph.stats().foreign_endpoints, 1U);

  graph.endpoint_is_there(chatter(peer(2), 6, true));
  graph.snapshot_came(end(peer(1), 4, true), snapshot_of(peer(1), "thief", {end(peer(2), 6, true)}));
  EXPECT_EQ(graph.ends_of_topic("/chatter").at(0).node_name, kUnknownNodeName);
  EXPECT_EQ(graph.stats().foreign_endpoints, 2U);
}

TEST(RemoteGraph, keeps_no_node_that_ros_2_could_not_have) {
  RemoteGraph graph{kUs};
  graph.participant_is_there(ros_participant(peer(1)));
  GraphSnapshot snapshot{peer(1)};
  snapshot.add_node("/", "good");
  snapshot.add_node("/", "bad\x1b[2J");
  snapshot.add_node("no_slash", "bad");
  graph.snapshot_came(end(peer(1), 4, true), msgs::to_cdr(snapshot.message()));

  EXPECT_THAT(names_of(graph), ElementsAre("/ good"));
  EXPECT_EQ(graph.stats().bad_nodes, 2U);
}

TEST(RemoteGraph, keeps_the_last_snapshot_when_a_broken_one_comes) {
  RemoteGraph graph{kUs};
  graph.participant_is_there(ros_participant(peer(1)));
  Bytes good = snapshot_of(peer(1), "talker");
  graph.snapshot_came(end(peer(1), 4, true), good);
  good.resize(good.size() - 9);
  graph.snapshot_came(end(peer(1), 4, true), good);
  graph.snapshot_came(end(peer(1), 4, true), {});

  EXPECT_THAT(names_of(graph), ElementsAre("/ talker"));
  EXPECT_EQ(graph.stats().broken_snapshots, 2U);
}

TEST(RemoteGraph, takes_in_no_more_than_its_limits) {
  RemoteGraphLimits limits;
  limits.participants = 3;
  limits.endpoints = 5;
  limits.endpoints_of_one = 2;
  RemoteGraph graph{kUs, limits};
  for (std::uint8_t n = 1; n <= 5; ++n) graph.participant_is_there(ros_participant(peer(n)));
  EXPECT_EQ(graph.stats().too_many_participants, 2U);

  for (std::uint8_t n = 1; n <= 3; ++n) {
    for (std::uint16_t i = 1; i <= 3; ++i) graph.endpoint_is_there(chatter(peer(n), i, true));
  }
  EXPECT_EQ(graph.ends_of_topic("/chatter").size(), 5U);
  EXPECT_EQ(graph.stats().too_many_endpoints, 4U);

  graph.participant_has_gone(peer(1));
  graph.participant_is_there(ros_participant(peer(4)));
  graph.endpoint_is_there(chatter(peer(4), 1, true));
  EXPECT_EQ(graph.ends_of_topic("/chatter").size(), 4U) << "there is room again";
  EXPECT_EQ(graph.stats().too_many_participants, 2U);
}

TEST(RemoteGraph, takes_in_no_snapshot_beyond_its_limits_and_keeps_the_old_one) {
  RemoteGraphLimits limits;
  limits.nodes_of_one = 2;
  limits.nodes = 3;
  limits.gids = 4;
  limits.snapshot_bytes = 400;
  RemoteGraph graph{kUs, limits};
  for (const std::uint8_t n : {1, 2}) graph.participant_is_there(ros_participant(peer(n)));
  const auto send = [&](std::uint8_t n, int nodes, std::uint16_t gids) {
    GraphSnapshot snapshot{peer(n)};
    for (int i = 0; i < nodes; ++i) snapshot.add_node("/", "n" + std::to_string(i));
    for (std::uint16_t i = 0; i < gids; ++i) EXPECT_TRUE(snapshot.add_endpoint("/", "n0", end(peer(n), i, true), true));
    const auto before = graph.stats().too_many_nodes;
    graph.snapshot_came(end(peer(n), 4, true), msgs::to_cdr(snapshot.message()));
    return graph.stats().too_many_nodes == before;
  };
  EXPECT_TRUE(send(1, 2, 3));
  EXPECT_FALSE(send(1, 3, 0)) << "nodes of one";
  EXPECT_FALSE(send(2, 2, 0)) << "nodes of all";
  EXPECT_FALSE(send(2, 1, 2)) << "gids of all";
  EXPECT_FALSE(send(2, 1, 40)) << "bytes";
  EXPECT_TRUE(send(2, 1, 1));
  EXPECT_TRUE(send(1, 2, 2)) << "its own old snapshot does not count";
  EXPECT_EQ(graph.nodes().size(), 3U);
}

TEST(RemoteGraph, has_no_memory_of_participants_that_left_nothing) {
  RemoteGraphLimits limits;
  limits.participants = 2;
  RemoteGraph graph{kUs, limits};
  for (std::uint8_t n = 1; n < 100; ++n) {
    graph.endpoint_is_there(chatter(peer(n), 6, true));
    graph.endpoint_has_gone(end(peer(n), 6, true));
    graph.snapshot_came(end(peer(n), 4, true), msgs::to_cdr(GraphSnapshot{peer(n)}.message()));
  }
  EXPECT_EQ(graph.stats().too_many_participants, 0U);
}

}  // namespace
}  // namespace nacelle::transport_dds
