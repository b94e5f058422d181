// SPDX-License-Identifier: Apache-2.0
#include "networking/network_message.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "nacelle/base/problem_json.hpp"
#include "networking/network_wish.hpp"
#include "transport_dds/wire/network_fault.hpp"

namespace nacelle::networking {
namespace {

using nlohmann::json;

/// As Network::state() has it.
json state_of(const transport_dds::NetworkSettings& settings) {
  json state = json_of(settings);
  state.update(
      {{"running", false}, {"figures", nullptr}, {"namesakes", json::array()}, {"clock_skews", json::array()}});
  state["problem"] = Problem{"network", "no interface", "plug one in"};
  return state;
}

TEST(NetworkMessage, has_what_there_is_and_empty_lists_for_what_there_is_not) {
  transport_dds::NetworkSettings settings;
  settings.domain = 7;
  settings.remote_control = true;
  settings.exports = {{"/scan", 5, 0, true}};
  settings.security.enabled = true;

  const auto message = network_message(state_of(settings));
  ASSERT_TRUE(message) << message.error().text();
  const auto& network = message.value();
  EXPECT_EQ(network.domain, 7);
  EXPECT_EQ(network.ports.first, 9150);
  EXPECT_TRUE(network.remote_control);
  ASSERT_EQ(network.exports.size(), 1U);
  ASSERT_EQ(network.exports[0].max_hz.size(), 1U);
  EXPECT_EQ(network.exports[0].max_hz[0], 5.0);
  EXPECT_TRUE(network.exports[0].max_bytes.empty());
  ASSERT_EQ(network.security.size(), 1U);
  EXPECT_FALSE(network.security[0].in_force);
  EXPECT_TRUE(network.security[0].subject.empty());
  ASSERT_EQ(network.problem.size(), 1U);
  EXPECT_EQ(network.problem[0].way_out, "plug one in");
  EXPECT_TRUE(network.figures.empty());
}

TEST(NetworkMessage, has_the_words_and_the_code_of_problems_that_have_a_place_and_a_value) {
  Problem remark{"ROS_STATIC_PEERS", "is not used", "take it out"};
  remark.code = transport_dds::NetworkFault::PeersUnused;
  remark.value = "10.0.0.2";
  Problem why{Place::of_parameter("interfaces", "/robot"), "there is no such interface", "plug it in"};
  why.value = "eth7";
  transport_dds::NetworkSettings settings;
  settings.remarks = {remark};
  json state = state_of(settings);
  state["problem"] = why;

  const auto message = network_message(state);
  ASSERT_TRUE(message) << message.error().text();
  ASSERT_EQ(message.value().remarks.size(), 1U);
  EXPECT_EQ(message.value().remarks[0].where, "ROS_STATIC_PEERS");
  EXPECT_EQ(message.value().remarks[0].code, "network.peers_unused");
  ASSERT_EQ(message.value().problem.size(), 1U);
  EXPECT_EQ(message.value().problem[0].what, "there is no such interface");
}

TEST(NetworkMessage, refuses_a_field_that_the_definition_does_not_have) {
  json state = state_of({});
  state["colour"] = "red";
  EXPECT_FALSE(network_message(state));
}

}  // namespace
}  // namespace nacelle::networking
