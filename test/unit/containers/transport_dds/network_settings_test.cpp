// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/network_settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "transport_dds/wire/cyclone_config.hpp"
#include "transport_dds/wire/network_fault.hpp"

namespace nacelle::transport_dds {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr const char* kRange = "ROS_AUTOMATIC_DISCOVERY_RANGE";
constexpr const char* kPeers = "ROS_STATIC_PEERS";

NetworkSettings settings_of(const NetworkWish& launch, const Environment& environment = {}) {
  auto settings = network_settings(launch, environment);
  EXPECT_TRUE(settings) << settings.error().text();
  return std::move(settings).value();
}
NetworkWish launch_with(NetworkMode mode) {
  NetworkWish wish;
  wish.mode = mode;
  return wish;
}
/// "network.overruled ROS_DOMAIN_ID=5": code, place and value of each remark.
std::vector<std::string> brief_remarks_of(const NetworkSettings& settings) {
  std::vector<std::string> all;
  for (const auto& remark : settings.remarks)
    all.push_back(remark.code.text() + " " + remark.where.text() + "=" + remark.value);
  return all;
}
std::string remarks_of(const NetworkSettings& settings) {
  std::string all;
  for (const auto& remark : settings.remarks) all += remark.text() + "\n";
  return all;
}

TEST(NetworkSettings, are_local_by_default) {
  const auto settings = settings_of({});

  EXPECT_EQ(settings.mode, NetworkMode::Local);
  EXPECT_EQ(settings.discovery, Reach::ThisMachine);
  EXPECT_EQ(settings.domain, 0);
  EXPECT_EQ(settings.because_of, "");
  EXPECT_THAT(settings.remarks, IsEmpty());
  EXPECT_EQ(network_line(settings), "network: local only; to show it to the LAN: network:=export");
  EXPECT_EQ(cyclone_config(settings),
            "<CycloneDDS><Domain><General>"
            "<MulticastRecvNetworkInterfaceAddresses>127.0.0.1</MulticastRecvNetworkInterfaceAddresses>"
            R"(<Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces>)"
            "<MaxMessageSize>65500B</MaxMessageSize><FragmentSize>65000B</FragmentSize></General>"
            "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
            R"(<Peers><Peer address="localhost"/></Peers></Discovery></Domain></CycloneDDS>)");
}

TEST(NetworkSettings, obey_the_range_of_ros) {
  const auto of = [](const char* range) { return settings_of({}, {{kRange, range}}); };
  EXPECT_EQ(of("OFF").mode, NetworkMode::Off);
  EXPECT_EQ(of("SUBNET").mode, NetworkMode::Export);
  const std::string frames =
      "<CycloneDDS><Domain><General><MaxMessageSize>1452B</MaxMessageSize></General>"
      "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
      "</Discovery></Domain></CycloneDDS>";
  EXPECT_EQ(cyclone_config(of("SUBNET")), frames) << "Cyclone's defaults but for these, as rmw_cyclonedds has them";
  EXPECT_EQ(cyclone_config(of("SYSTEM_DEFAULT")), frames);
  EXPECT_EQ(of("LOCALHOST").mode, NetworkMode::Local);
  EXPECT_EQ(of("LOCALHOST").because_of, kRange);
  EXPECT_EQ(cyclone_config(of("LOCALHOST")), cyclone_config(settings_of({})));
}

TEST(NetworkSettings, show_the_robot_to_peers_alone_where_only_peers_are_named) {
  NetworkWish launch;
  launch.peers = {"10.0.0.7"};
  for (const auto& settings : {settings_of(launch), settings_of({}, {{kPeers, "10.0.0.7"}}),
                               settings_of({}, {{kPeers, "10.0.0.7"}, {kRange, "LOCALHOST"}})}) {
    EXPECT_EQ(settings.mode, NetworkMode::Export);
    EXPECT_EQ(settings.discovery, Reach::Unicast);
    EXPECT_THAT(cyclone_config(settings), HasSubstr(R"(<Peer address="localhost"/><Peer address="10.0.0.7"/>)"));
    EXPECT_THAT(cyclone_config(settings), HasSubstr("<AllowMulticast>false"));
    EXPECT_EQ(network_line(settings), "network: shown to 10.0.0.7; to keep it on this machine: network:=local");
  }
}

TEST(NetworkSettings, ask_peers_besides_the_lan) {
  NetworkWish launch = launch_with(NetworkMode::Export);
  launch.peers = {"10.0.0.7", "10.0.0.8"};
  launch.interfaces = {"eth0", "10.0.0.1"};
  const auto settings = settings_of(launch, {{kPeers, "10.0.0.8;10.0.0.9"}});

  EXPECT_EQ(settings.discovery, Reach::Multicast);
  EXPECT_THAT(settings.peers, ElementsAre("10.0.0.7", "10.0.0.8", "10.0.0.9"));
  EXPECT_THAT(settings.remarks, IsEmpty());
  const std::string config = cyclone_config(settings);
  EXPECT_THAT(config, HasSubstr(R"(<NetworkInterface name="eth0"/><NetworkInterface address="10.0.0.1"/>)"));
  EXPECT_THAT(config, HasSubstr(R"(<Peer address="10.0.0.9"/>)"));
  EXPECT_THAT(config, Not(HasSubstr("localhost")));
  EXPECT_THAT(config, Not(HasSubstr("AllowMulticast")));
  EXPECT_EQ(network_line(settings), "network: shown to the LAN; to keep it on this machine: network:=local");
}

TEST(NetworkSettings, of_the_launch_file_win_and_say_so) {
  NetworkWish launch = launch_with(NetworkMode::Local);
  launch.domain_id = 7;
  const auto settings = settings_of(launch, {{kRange, "SUBNET"}, {"ROS_DOMAIN_ID", "5"}, {kPeers, "10.0.0.7"}});

  EXPECT_EQ(settings.mode, NetworkMode::Local);
  EXPECT_EQ(settings.discovery, Reach::ThisMachine);
  EXPECT_EQ(settings.domain, 7);
  EXPECT_THAT(settings.peers, IsEmpty());
  EXPECT_THAT(brief_remarks_of(settings),
              ElementsAre("network.overruled ROS_AUTOMATIC_DISCOVERY_RANGE=export", "network.overruled ROS_DOMAIN_ID=5",
                          "network.peers_unused ROS_STATIC_PEERS=10.0.0.7"));
  EXPECT_EQ(network_line(settings), "network: local only, domain 7; to show it to the LAN: network:=export");
}

TEST(NetworkSettings, find_tools_of_this_machine_however_these_look) {
  const NetworkWish local = launch_with(NetworkMode::Local);
  for (const Environment& environment :
       {Environment{{kRange, "LOCALHOST"}}, Environment{{kRange, "SUBNET"}},
        Environment{{kRange, "LOCALHOST"}, {kPeers, "10.0.0.7"}}, Environment{{"ROS_LOCALHOST_ONLY", "1"}}})
    EXPECT_EQ(settings_of(local, environment).discovery, Reach::ThisMachine);
  EXPECT_EQ(settings_of(launch_with(NetworkMode::Export), {{kRange, "LOCALHOST"}}).discovery, Reach::Multicast);
  EXPECT_EQ(settings_of(launch_with(NetworkMode::Off), {{kRange, "SUBNET"}}).discovery, Reach::None);
}

TEST(NetworkSettings, of_this_machine_are_on_lo_and_on_its_addresses_and_join_groups_on_lo_alone) {
  NetworkWish launch = launch_with(NetworkMode::Local);
  launch.interfaces = {"wlan0"};
  NetworkSettings settings = settings_of(launch);
  EXPECT_THAT(settings.interfaces, ElementsAre("lo")) << "a launch file chooses for the LAN";
  settings.interfaces.emplace_back("192.168.1.20");
  EXPECT_THAT(
      cyclone_config(settings),
      HasSubstr("<General><MulticastRecvNetworkInterfaceAddresses>127.0.0.1</MulticastRecvNetworkInterfaceAddresses>"
                R"(<Interfaces><NetworkInterface name="lo" multicast="true"/>)"
                R"(<NetworkInterface address="192.168.1.20"/></Interfaces>)"));
  settings.interfaces.clear();
  EXPECT_THAT(cyclone_config(settings), Not(HasSubstr("NetworkInterface ")));
}

TEST(NetworkSettings, obey_localhost_only_before_range_and_peers) {
  const auto settings = settings_of({}, {{"ROS_LOCALHOST_ONLY", "1"}, {kRange, "SUBNET"}, {kPeers, "10.0.0.7"}});

  EXPECT_EQ(settings.mode, NetworkMode::Local);
  EXPECT_EQ(settings.discovery, Reach::ThisMachine);
  EXPECT_THAT(settings.peers, IsEmpty());
  EXPECT_EQ(settings.because_of, "ROS_LOCALHOST_ONLY");
  EXPECT_EQ(settings_of({}, {{"ROS_LOCALHOST_ONLY", "0"}, {kRange, "SUBNET"}}).mode, NetworkMode::Export);
}

TEST(NetworkSettings, leave_cyclonedds_uri_the_last_word_and_say_so) {
  const auto settings = settings_of({}, {{"CYCLONEDDS_URI", "file:///etc/cyclone.xml"}});

  EXPECT_THAT(cyclone_config(settings), ::testing::EndsWith("</CycloneDDS>,file:///etc/cyclone.xml"));
  EXPECT_THAT(brief_remarks_of(settings),
              ElementsAre("network.configuration_taken CYCLONEDDS_URI=file:///etc/cyclone.xml"));
  EXPECT_THAT(network_line(settings), HasSubstr("as CYCLONEDDS_URI allows"));
  EXPECT_THAT(cyclone_config(settings_of({}, {{"CYCLONEDDS_URI", "x"}, {kRange, "SUBNET"}})),
              ::testing::EndsWith(",x"));
}

TEST(NetworkSettings, take_security_from_the_environment_or_the_launch_file) {
  const Environment shell{{"ROS_SECURITY_ENABLE", "true"},
                          {"ROS_SECURITY_KEYSTORE", "/shell"},
                          {"ROS_SECURITY_ENCLAVE_OVERRIDE", "/laptop"}};
  EXPECT_EQ(settings_of({}, shell).security, (SecurityWish{true, false, "/shell", "/laptop"}));

  NetworkWish launch;
  launch.security = SecurityWish{true, true, "", "/robot"};
  const auto settings = settings_of(launch, shell);
  EXPECT_EQ(settings.security, (SecurityWish{true, true, "/shell", "/robot"}))
      << "the shell supplies what the launch file leaves out";
  EXPECT_THAT(brief_remarks_of(settings), ElementsAre("network.overruled ROS_SECURITY_STRATEGY=Permissive",
                                                      "network.overruled ROS_SECURITY_ENCLAVE_OVERRIDE=/laptop"));
  EXPECT_THAT(brief_remarks_of(settings_of(launch, {{"ROS_SECURITY_ENABLE", "false"}})),
              ElementsAre("network.overruled ROS_SECURITY_ENABLE=false"));
  EXPECT_THAT(settings_of(launch, {{"ROS_SECURITY_KEYSTORE", "/shell"}}).remarks, IsEmpty());
}

TEST(NetworkSettings, say_whether_they_are_secured) {
  NetworkSettings settings = settings_of({}, {{"ROS_SECURITY_ENABLE", "true"}});
  EXPECT_THAT(network_line(settings), HasSubstr("local only, without the security that was requested;"));
  settings.secured = SecuredBy{"/robot", {}, "CN=/robot", "2036-11-19"};
  EXPECT_EQ(network_line(settings), "network: local only, secured as /robot; to show it to the LAN: network:=export");
}

TEST(NetworkSettings, of_a_network_that_is_off_say_how_to_switch_it_on) {
  EXPECT_EQ(network_line(settings_of(launch_with(NetworkMode::Off))),
            "network: off; to let tools of this machine see it: network:=local");
}

TEST(NetworkSettings, refuse_what_is_no_setting_with_key_and_value) {
  const auto refusal = [](const auto& change) {
    NetworkWish wish;
    change(wish);
    const auto settings = network_settings(wish, {});
    if (settings) return std::string("accepted");
    EXPECT_EQ(settings.error().code, NetworkFault::WrongSetting);
    return settings.error().where.text() + "=" + settings.error().value;
  };
  EXPECT_EQ(refusal([](auto& w) { w.domain_id = 233; }), "network: domain_id=233");
  EXPECT_EQ(refusal([](auto& w) { w.domain_id = -1; }), "network: domain_id=-1");
  EXPECT_EQ(refusal([](auto& w) { w.interfaces = {"eth0\"/>"}; }), "network: interfaces=eth0\"/>");
  EXPECT_EQ(refusal([](auto& w) { w.interfaces = {""}; }), "network: interfaces=");
  EXPECT_EQ(refusal([](auto& w) { w.peers = {"a b"}; }), "network: peers=a b");
  EXPECT_EQ(refusal([](auto& w) { w.exports = {{"scan"}}; }), "network: export=scan");
  EXPECT_EQ(refusal([](auto& w) { w.exports = {{"/scan", -1.0}}; }), "network: export=/scan");
  EXPECT_EQ(refusal([](auto& w) {
              w.exports = {{"/scan", std::numeric_limits<double>::quiet_NaN()}};
            }),
            "network: export=/scan");
  EXPECT_EQ(refusal([](auto& w) { w.exports = {{"/scan", 5.0, 1000, true}}; }), "accepted");
  const Problem variable = network_settings({}, {{"ROS_DOMAIN_ID", "x"}}).error();
  EXPECT_EQ(variable.code, NetworkFault::WrongSetting);
  EXPECT_EQ(variable.where, Place("ROS_DOMAIN_ID"));
  EXPECT_EQ(variable.value, "x");
}

TEST(NetworkSettings, word_remarks_and_refusals_like_this) {
  NetworkWish launch = launch_with(NetworkMode::Local);
  launch.domain_id = 7;
  EXPECT_EQ(remarks_of(settings_of(launch, {{kRange, "SUBNET"}, {"ROS_DOMAIN_ID", "5"}, {kPeers, "10.0.0.7"}})),
            "ROS_AUTOMATIC_DISCOVERY_RANGE: it asks for export, the launch file says local, which is in force\n"
            "ROS_DOMAIN_ID: it says 5, the launch file says 7, which is in force\n"
            "ROS_STATIC_PEERS: peers are not asked in this mode; network:=export shows the robot to them\n");
  EXPECT_THAT(remarks_of(settings_of({}, {{"CYCLONEDDS_URI", "x"}})), HasSubstr("Cyclone reads it after Nacelle's"));
  launch.domain_id = 233;
  EXPECT_EQ(network_settings(launch, {}).error().text(),
            "network: domain_id: 233 is not a domain; 0 to 101 work everywhere");
}

TEST(NetworkSettings, have_three_modes) {
  for (const auto mode : {NetworkMode::Off, NetworkMode::Local, NetworkMode::Export}) {
    EXPECT_EQ(parse_network_mode(to_text(mode)).value(), mode);
  }
  const Problem wrong = parse_network_mode("exprot").error();
  EXPECT_EQ(wrong.code, NetworkFault::WrongSetting);
  EXPECT_EQ(wrong.value, "exprot");
  EXPECT_EQ(wrong.way_out, "did you mean 'export'?");
}

TEST(NetworkSettings, carry_on_what_they_do_not_judge) {
  NetworkWish launch = launch_with(NetworkMode::Export);
  launch.allow_load = launch.remote_control = true;
  launch.exports = {{"/scan", 5.0}};
  const auto settings = settings_of(launch, {{"ROS_SECURITY_ENABLE", "true"}, {"ROS_SECURITY_STRATEGY", "Enforce"}});

  EXPECT_TRUE(settings.allow_load);
  EXPECT_TRUE(settings.remote_control);
  EXPECT_EQ(settings.exports, launch.exports);
  EXPECT_TRUE(settings.security.enforced);
}

TEST(DomainPorts, are_those_of_rtps) {
  EXPECT_EQ(ports_of_domain(0).first, 7400);
  EXPECT_EQ(ports_of_domain(42, 0).last, 17911);
  EXPECT_EQ(ports_of_domain(101).last, 32725);
}

TEST(DomainPorts, that_the_kernel_gives_to_any_program_are_reported_with_both_ranges) {
  constexpr PortRange kUsual{32768, 60999};
  EXPECT_FALSE(port_remark(0, kUsual));
  EXPECT_FALSE(port_remark(101, kUsual));
  EXPECT_FALSE(port_remark(215, kUsual));
  const auto remark = port_remark(102, kUsual);
  ASSERT_TRUE(remark);
  EXPECT_EQ(remark->text(),
            "domain 102: its UDP ports 32900 to 32975 reach those from 32768 to 60999 that the kernel gives to any "
            "program; take "
            "another domain, or `sysctl net.ipv4.ip_local_reserved_ports=32900-32975`");
  EXPECT_TRUE(port_remark(1, {7700, 7800})) << "a machine with another range";
  EXPECT_TRUE(port_remark(214, kUsual)) << "its multicast ports";
}

TEST(DomainPorts, that_are_reserved_are_not_given_away) {
  constexpr PortRange kUsual{32768, 60999};
  const auto remark_with = [&](const char* reserved) { return port_remark(102, kUsual, parse_port_ranges(reserved)); };
  EXPECT_FALSE(remark_with("32900-32975")) << "the way out of the remark";
  EXPECT_FALSE(remark_with("80,32000-32930,32931,32932-40000\n"));
  EXPECT_TRUE(remark_with("32900-32974"));
  EXPECT_TRUE(remark_with("32901-32975"));
  EXPECT_TRUE(remark_with("32900"));
  for (const char* none : {"", "\n", "x", "-", "32900-", "32900-x,", ",,"}) EXPECT_TRUE(remark_with(none)) << none;
}

}  // namespace
}  // namespace nacelle::transport_dds
