// SPDX-License-Identifier: Apache-2.0
#include "networking/network_wish.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace nacelle::networking {
namespace {

using transport_dds::NetworkMode;

launch::NetworkPlan asking_for(launch::NetworkMode mode, bool by_argument = false) {
  launch::NetworkPlan plan;
  plan.mode = mode;
  plan.mode_by_argument = by_argument;
  return plan;
}
transport_dds::NetworkSettings in_force(const launch::NetworkPlan& plan,
                                        const transport_dds::Environment& environment = {}) {
  auto settings = network_in_force(plan, environment);
  EXPECT_TRUE(settings) << settings.error().text();
  return settings ? std::move(settings).value() : transport_dds::NetworkSettings{};
}

TEST(NetworkInForce, passes_on_every_setting_of_the_launch_file) {
  launch::NetworkPlan plan = asking_for(launch::NetworkMode::Export);
  plan.domain_id = 7;
  plan.interfaces = {"eth0"};
  plan.peers = {"laptop"};
  plan.allow_load = plan.remote_control = true;
  plan.exports = {{"/scan", 5, 1000, true, {}}};
  const auto settings = in_force(plan);
  EXPECT_EQ(settings.mode, NetworkMode::Export);
  EXPECT_EQ(settings.because_of, "network: mode");
  EXPECT_EQ(settings.domain, 7);
  EXPECT_EQ(settings.interfaces, std::vector<std::string>{"eth0"});
  EXPECT_EQ(settings.peers, std::vector<std::string>{"laptop"});
  EXPECT_TRUE(settings.allow_load);
  EXPECT_TRUE(settings.remote_control);
  EXPECT_EQ(settings.exports, (std::vector<transport_dds::ExportRule>{{"/scan", 5, 1000, true}}));
  const auto words = json_of(settings);
  EXPECT_EQ(words["exports"][0]["max_hz"], 5);
  EXPECT_EQ(words["ports"]["first"], 9150);
  EXPECT_EQ(words["interfaces"], nlohmann::json::array({"eth0"}));
}

TEST(NetworkInForce, names_the_word_of_the_command_line_that_has_set_it) {
  EXPECT_EQ(in_force(asking_for(launch::NetworkMode::Off, true)).because_of, "network:=off");
  EXPECT_EQ(in_force({}, {{"ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"}}).because_of, "ROS_AUTOMATIC_DISCOVERY_RANGE");
  EXPECT_EQ(in_force({}).because_of, "");
}

TEST(NetworkInForce, is_none_where_security_is_enforced_and_cannot_be_had) {
  const transport_dds::Environment enforced{
      {"ROS_SECURITY_ENABLE", "true"}, {"ROS_SECURITY_STRATEGY", "Enforce"}, {"ROS_SECURITY_KEYSTORE", "/no/such"}};
  const auto refused = network_in_force(asking_for(launch::NetworkMode::Export), enforced);
  ASSERT_FALSE(refused);
#ifdef NACELLE_HAS_SECURITY
  EXPECT_EQ(refused.error().text(),
            "/no/such: this is not a keystore: it has no folder enclaves; make one: `nacelle security create-keystore "
            "/no/such`");
#endif
  EXPECT_EQ(in_force(asking_for(launch::NetworkMode::Off), enforced).mode, NetworkMode::Off)
      << "mode off needs no keystore";
}

TEST(NetworkInForce, continues_unsecured_with_a_warning_if_security_is_permissive) {
  launch::NetworkPlan plan = asking_for(launch::NetworkMode::Export);
  plan.security = launch::SecurityPlan{"/no/such", "/robot", false, {}};
  const auto settings = in_force(plan);
  EXPECT_EQ(settings.mode, NetworkMode::Export);
  EXPECT_FALSE(settings.secured);
  ASSERT_EQ(settings.remarks.size(), 1U);
  EXPECT_THAT(settings.remarks[0].text(), ::testing::HasSubstr("everything goes in the clear"));
  EXPECT_EQ(transport_dds::network_line(settings),
            "network: shown to the LAN, without the security that was requested; to keep it on this machine: "
            "network:=local");
  const auto words = json_of(settings);
  EXPECT_EQ(words["security"]["in_force"], false);
  EXPECT_EQ(words["security"]["strategy"], "Permissive");
  EXPECT_EQ(json_of(in_force({}))["security"], nullptr);
}

TEST(NetworkInForce, refuses_a_domain_that_is_none) {
  const auto refused = network_in_force({}, {{"ROS_DOMAIN_ID", "lab"}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(network_off_line(refused.error()).rfind("network: off, since ROS_DOMAIN_ID: 'lab' is not a number", 0), 0U);
}

TEST(NetworkInForce, in_json_lists_lo_first) {
  const auto words = json_of(in_force({}));
  EXPECT_EQ(words["interfaces"].at(0), "lo") << "and the addresses of the machine, which are others everywhere";
  EXPECT_EQ(words["mode"], "local");
  EXPECT_EQ(words["line"], "network: local only; to show it to the LAN: network:=export");
}

}  // namespace
}  // namespace nacelle::networking
