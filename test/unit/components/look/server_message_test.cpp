// SPDX-License-Identifier: Apache-2.0
#include "look/protocol/server_message.hpp"

#include <gtest/gtest.h>

#include "nacelle/base/json_text.hpp"

namespace nacelle::look {
namespace {

using nlohmann::json;

TEST(ServerMessage, the_greeting_names_what_the_server_can_do) {
  const json info = parse_json_or_discard(server_info({"robot", {"services"}, {{"nacelle.right", "view"}}, "7"}));
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["capabilities"], json({"services"}));
  EXPECT_EQ(info["supportedEncodings"], json({"cdr", "json"}));
  EXPECT_EQ(info["metadata"]["nacelle.right"], "view");
  EXPECT_EQ(info["sessionId"], "7");
}

TEST(ServerMessage, channels_and_services_carry_their_definitions) {
  const json channels = parse_json_or_discard(advertise({{4, "/scan", "sensor_msgs/msg/LaserScan", "float32 x"}}));
  EXPECT_EQ(channels["op"], "advertise");
  EXPECT_EQ(channels["channels"][0], (json{{"id", 4},
                                           {"topic", "/scan"},
                                           {"encoding", "cdr"},
                                           {"schemaName", "sensor_msgs/msg/LaserScan"},
                                           {"schema", "float32 x"},
                                           {"schemaEncoding", "ros2msg"}}));
  const json services =
      parse_json_or_discard(advertise_services({{5, "/stop", "std_srvs/srv/SetBool", "bool data", "bool success"}}));
  const json& service = services["services"][0];
  EXPECT_EQ(service["type"], "std_srvs/srv/SetBool");
  EXPECT_EQ(service["request"]["schemaName"], "std_srvs/srv/SetBool_Request");
  EXPECT_EQ(service["request"]["schema"], "bool data");
  EXPECT_EQ(service["responseSchema"], "bool success");
  EXPECT_EQ(parse_json_or_discard(unadvertise({1, 2}))["channelIds"], json({1, 2}));
  EXPECT_EQ(parse_json_or_discard(unadvertise_services({3}))["serviceIds"], json({3}));
}

TEST(ServerMessage, names_that_are_no_utf_8_are_written_all_the_same) {
  EXPECT_EQ(parse_json_or_discard(status(StatusLevel::Error, "\xff"))["message"], "\xEF\xBF\xBD");
}

TEST(ServerMessage, an_answer_about_parameters_has_the_questions_id) {
  EXPECT_EQ(parse_json_or_discard(parameter_values(json::array(), "q"))["id"], "q");
  EXPECT_FALSE(parse_json_or_discard(parameter_values(json::array(), "")).contains("id"));
}

TEST(ServerMessage, the_graph_tells_what_has_changed) {
  ConnectionGraph before, now;
  before.published = {{"/gone", {"/a"}}, {"/same", {"/a"}}, {"/half", {"/a"}}};
  before.subscribed = {{"/half", {"/b"}}, {"/gone", {"/b"}}};
  before.services = {{"/old", {"/a"}}};
  now.published = {{"/same", {"/a"}}, {"/new", {"/a", "/b"}}};
  now.subscribed = {{"/half", {"/b"}}};
  const json update = parse_json_or_discard(connection_graph_update(before, now));
  EXPECT_EQ(update["op"], "connectionGraphUpdate");
  EXPECT_EQ(update["publishedTopics"], json({{{"name", "/new"}, {"publisherIds", {"/a", "/b"}}},
                                             {{"name", "/gone"}, {"publisherIds", json::array()}},
                                             {{"name", "/half"}, {"publisherIds", json::array()}}}));
  EXPECT_EQ(update["removedTopics"], json({"/gone"}));
  EXPECT_EQ(update["removedServices"], json({"/old"}));
}

// The layouts of the specification, little-endian.
TEST(ServerMessage, binary_frames_have_the_specified_layout) {
  EXPECT_EQ(message_head(0x04030201, 0x0807060504030201), (Bytes{1, 1, 2, 3, 4, 1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(message_head(0, 0).size(), kMessageHead);
  EXPECT_EQ(time_frame(1), (Bytes{2, 1, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(service_response(1, 2, "cdr", Bytes{9}), (Bytes{3, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 'c', 'd', 'r', 9}));
  EXPECT_EQ(asset(5, Bytes{1, 2}), (Bytes{4, 5, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2}));
  EXPECT_EQ(asset_failure(5, "no"), (Bytes{4, 5, 0, 0, 0, 1, 2, 0, 0, 0, 'n', 'o'}));
}

}  // namespace
}  // namespace nacelle::look
