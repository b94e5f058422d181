// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/ros_environment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nacelle::transport_dds {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

EnvironmentWish wish_of(const Environment& environment) {
  auto wish = read_environment(environment);
  EXPECT_TRUE(wish) << wish.error().text();
  return std::move(wish).value();
}

// The remark on one variable when nothing else is set.
std::string remark_on(const std::string& name, const std::string& value) {
  const auto wish = wish_of({{name, value}});
  EXPECT_LE(wish.remarks.size(), 1U);
  return wish.remarks.empty() ? "" : wish.remarks[0].text();
}

TEST(RosEnvironment, that_is_empty_asks_for_nothing) {
  for (const Environment& environment :
       {Environment{}, Environment{{"ROS_DOMAIN_ID", ""}, {"ROS_STATIC_PEERS", ""}, {"PATH", "/bin"}}}) {
    const auto wish = wish_of(environment);
    EXPECT_EQ(wish.domain, std::nullopt);
    EXPECT_EQ(wish.range, std::nullopt);
    EXPECT_FALSE(wish.localhost_only);
    EXPECT_THAT(wish.peers, IsEmpty());
    EXPECT_EQ(wish.security, SecurityWish{});
    EXPECT_THAT(wish.remarks, IsEmpty());
  }
}

TEST(RosEnvironment, names_a_domain_as_rcl_reads_numbers) {
  EXPECT_EQ(wish_of({{"ROS_DOMAIN_ID", "42"}}).domain, 42);
  EXPECT_EQ(wish_of({{"ROS_DOMAIN_ID", "0x2a"}}).domain, 42);
  EXPECT_EQ(wish_of({{"ROS_DOMAIN_ID", "052"}}).domain, 42);
  EXPECT_EQ(wish_of({{"ROS_DOMAIN_ID", "0"}}).domain, 0);
  EXPECT_EQ(wish_of({{"ROS_DOMAIN_ID", "232"}}).domain, 232);
  for (const char* wrong : {"forty", "42x", "-1", " 42", "233", "99999999999999999999", "0x", "08"}) {
    const auto wish = read_environment({{"ROS_DOMAIN_ID", wrong}});
    ASSERT_FALSE(wish) << wrong;
    EXPECT_EQ(wish.error().where.text(), "ROS_DOMAIN_ID");
  }
}

TEST(RosEnvironment, tells_a_number_that_is_no_domain_from_what_is_no_number) {
  for (const char* wrong : {"-1", "233", "99999999999", "-99999999999", "-0x1"}) {
    const auto wish = read_environment({{"ROS_DOMAIN_ID", wrong}});
    ASSERT_FALSE(wish) << wrong;
    EXPECT_EQ(wish.error().text(), "ROS_DOMAIN_ID: '" + std::string(wrong) +
                                       "' is not a domain; give a number from 0 to 232; 0 to 101 work everywhere");
  }
  for (const char* wrong : {"forty", "--1", "-", "0x", "1e3"})
    EXPECT_EQ(read_environment({{"ROS_DOMAIN_ID", wrong}}).error().what,
              "'" + std::string(wrong) + "' is not a number");
}

TEST(RosEnvironment, says_how_a_domain_is_read_that_is_not_written_plainly) {
  EXPECT_EQ(remark_on("ROS_DOMAIN_ID", "0x0"), "ROS_DOMAIN_ID: '0x0' is read as 0, as ROS 2 reads it; write 0");
  EXPECT_EQ(remark_on("ROS_DOMAIN_ID", "052"), "ROS_DOMAIN_ID: '052' is read as 42, as ROS 2 reads it; write 42");
  EXPECT_EQ(remark_on("ROS_DOMAIN_ID", "42"), "");
}

TEST(RosEnvironment, names_a_range) {
  EXPECT_EQ(wish_of({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"}}).range, DiscoveryRange::Off);
  EXPECT_EQ(wish_of({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"}}).range, DiscoveryRange::Localhost);
  EXPECT_EQ(wish_of({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"}}).range, DiscoveryRange::Subnet);
  EXPECT_EQ(wish_of({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "SYSTEM_DEFAULT"}}).range, DiscoveryRange::SystemDefault);
  EXPECT_EQ(wish_of({{"ROS_AUTOMATIC_DISCOVERY_RANGE", "subnet"}}).range, DiscoveryRange::Localhost)
      << "as rcl takes it";
  EXPECT_EQ(remark_on("ROS_AUTOMATIC_DISCOVERY_RANGE", "subnet"),
            "ROS_AUTOMATIC_DISCOVERY_RANGE: 'subnet' is not a range, LOCALHOST is taken; did you mean 'SUBNET'?");
  EXPECT_STREQ(to_text(DiscoveryRange::SystemDefault), "SYSTEM_DEFAULT");
}

TEST(RosEnvironment, lists_peers) {
  EXPECT_THAT(wish_of({{"ROS_STATIC_PEERS", "10.0.0.7;robot.local;;[fe80::1%eth0]:7410;"}}).peers,
              ElementsAre("10.0.0.7", "robot.local", "[fe80::1%eth0]:7410"));
  const auto wish = wish_of({{"ROS_STATIC_PEERS", "a\"/><Peer;b"}});
  EXPECT_THAT(wish.peers, ElementsAre("b"));
  ASSERT_EQ(wish.remarks.size(), 1U);
  EXPECT_EQ(wish.remarks[0].where.text(), "ROS_STATIC_PEERS");
  EXPECT_NE(remark_on("ROS_STATIC_PEERS", std::string(256, 'a')).find("255 bytes"), std::string::npos);
}

TEST(RosEnvironment, says_that_localhost_only_is_deprecated) {
  EXPECT_TRUE(wish_of({{"ROS_LOCALHOST_ONLY", "1"}}).localhost_only);
  EXPECT_FALSE(wish_of({{"ROS_LOCALHOST_ONLY", "0"}}).localhost_only);
  EXPECT_NE(remark_on("ROS_LOCALHOST_ONLY", "1").find("obeyed"), std::string::npos);
  EXPECT_NE(remark_on("ROS_LOCALHOST_ONLY", "0").find("switches nothing"), std::string::npos);
}

TEST(RosEnvironment, asks_for_security) {
  EXPECT_EQ(wish_of({{"ROS_SECURITY_ENABLE", "true"},
                     {"ROS_SECURITY_STRATEGY", "Enforce"},
                     {"ROS_SECURITY_KEYSTORE", "/k"},
                     {"ROS_SECURITY_ENCLAVE_OVERRIDE", "/robot"}})
                .security,
            (SecurityWish{true, true, "/k", "/robot"}));
  EXPECT_FALSE(wish_of({{"ROS_SECURITY_STRATEGY", "Enforce"}}).security.enforced) << "not enabled";
  EXPECT_NE(remark_on("ROS_SECURITY_ENABLE", "1"), "");
  const auto strategy = wish_of({{"ROS_SECURITY_ENABLE", "true"}, {"ROS_SECURITY_STRATEGY", "enforce"}});
  EXPECT_FALSE(strategy.security.enforced);
  EXPECT_EQ(strategy.remarks.size(), 1U) << "a misspelt strategy is remarked on";
}

TEST(RosEnvironment, has_an_answer_to_every_other_variable_of_ros) {
  EXPECT_EQ(remark_on("ROS_DISCOVERY_SERVER", "10.0.0.1:11811").find("ROS_DISCOVERY_SERVER: Fast DDS only"), 0U);
  EXPECT_EQ(remark_on("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp"), "");
  EXPECT_NE(remark_on("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp").find("services and actions do not"), std::string::npos);
  EXPECT_NE(remark_on("RMW_IMPLEMENTATION", "rmw_zenoh_cpp").find("does not see"), std::string::npos);
  EXPECT_NE(remark_on("RMW_FASTRTPS_USE_QOS_FROM_XML", "1").find("Fast DDS only"), std::string::npos);
  EXPECT_EQ(remark_on("ROS_DOMIAN_ID", "5"), "ROS_DOMIAN_ID: nothing here reads it; did you mean ROS_DOMAIN_ID?");
  EXPECT_EQ(remark_on("ROS_QUITE_ANOTHER_THING", "1"), "ROS_QUITE_ANOTHER_THING: nothing here reads it");
  for (const char* description : {"ROS_DISTRO", "ROS_VERSION", "ROS_PYTHON_VERSION", "ROS_HOME"}) {
    EXPECT_EQ(remark_on(description, "x"), "") << description;
  }
}

}  // namespace
}  // namespace nacelle::transport_dds
