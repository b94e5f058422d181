// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "in_memory.hpp"

namespace nacelle::launch {
namespace {

using Arguments = std::map<std::string, std::string>;

Result<Plan, std::vector<Problem>> load_network(const std::string& text, const Arguments& arguments = {}) {
  return load_plan_text("launch:\n" + text, "a.launch.yaml", arguments, in_memory({}));
}
NetworkPlan network_of(const std::string& text, const Arguments& arguments = {}) {
  auto plan = load_network(text, arguments);
  EXPECT_TRUE(plan) << problems_of(plan);
  return plan ? plan->network : NetworkPlan{};
}
std::string mistakes_of(const std::string& text, const Arguments& arguments = {}) {
  return problems_of(load_network(text, arguments));
}

TEST(Network, is_read_whole) {
  const NetworkPlan network = network_of(R"(
- network:
    mode: export
    domain_id: 42
    interfaces: [eth0, 192.168.1.5]
    peers: [laptop.local, 10.0.0.7]
    allow_load: true
    remote_control: true
    export:
    - {topic: /scan, max_hz: 5}
    - {topic: camera/image_raw, max_bytes: 2000000, compressed_only: true}
)");
  EXPECT_TRUE(network.declared);
  EXPECT_EQ(network.where.text(), "a.launch.yaml:3");
  EXPECT_EQ(network.mode, NetworkMode::Export);
  EXPECT_FALSE(network.mode_by_argument);
  EXPECT_EQ(network.domain_id, 42);
  EXPECT_EQ(network.interfaces, (std::vector<std::string>{"eth0", "192.168.1.5"}));
  EXPECT_EQ(network.peers, (std::vector<std::string>{"laptop.local", "10.0.0.7"}));
  EXPECT_TRUE(network.allow_load);
  EXPECT_TRUE(network.remote_control);
  ASSERT_EQ(network.exports.size(), 2U);
  EXPECT_EQ(network.exports[0].topic, "/scan");
  EXPECT_EQ(network.exports[0].max_hz, 5.0);
  EXPECT_EQ(network.exports[0].max_bytes_per_s, 0U);
  EXPECT_EQ(network.exports[1].topic, "/camera/image_raw");
  EXPECT_EQ(network.exports[1].max_bytes_per_s, 2'000'000U);
  EXPECT_TRUE(network.exports[1].compressed_only);
  EXPECT_EQ(network.exports[1].where.text(), "a.launch.yaml:12");
}

TEST(Network, says_nothing_where_nothing_is_written) {
  const NetworkPlan network = network_of("- log: {message: hello}");
  EXPECT_FALSE(network.declared);
  EXPECT_FALSE(network.mode);
  EXPECT_FALSE(network.domain_id);
  EXPECT_TRUE(network.exports.empty());
  EXPECT_FALSE(network.allow_load);
  EXPECT_FALSE(network.remote_control);
}

TEST(Network, off_is_a_mode_and_no_truth_value) {
  EXPECT_EQ(network_of("- network: {mode: off}").mode, NetworkMode::Off);
  EXPECT_EQ(network_of("- network: {mode: local}").mode, NetworkMode::Local);
}

TEST(Network, lists_topics_without_limits_as_plain_names) {
  const NetworkPlan network = network_of("- push_ros_namespace: {namespace: arm}\n- network: {export: [scan, /tf]}");
  ASSERT_EQ(network.exports.size(), 2U);
  EXPECT_EQ(network.exports[0].topic, "/arm/scan");
  EXPECT_EQ(network.exports[1].topic, "/tf");
}

TEST(Network, has_a_mode_of_the_command_line) {
  const std::string file = "- network: {mode: local, domain_id: 3}";
  const NetworkPlan network = network_of(file, {{"network", "export"}});
  EXPECT_EQ(network.mode, NetworkMode::Export);
  EXPECT_TRUE(network.mode_by_argument);
  EXPECT_EQ(network.domain_id, 3);
  EXPECT_EQ(network_of("- log: {message: a file without it}", {{"network", "off"}}).mode, NetworkMode::Off);
}

TEST(Network, of_the_command_line_is_the_files_own_where_it_declares_an_argument_of_that_name) {
  const std::string file = "- arg: {name: network, default: lan}\n- let: {name: used, value: $(var network)}";
  const NetworkPlan network = network_of(file, {{"network", "wan"}});
  EXPECT_FALSE(network.mode);
  EXPECT_EQ(
      network_of("- arg: {name: network, default: local}\n- network: {mode: $(var network)}", {{"network", "export"}})
          .mode,
      NetworkMode::Export);
}

TEST(Network, may_stand_behind_conditions) {
  const std::string file =
      "- arg: {name: lan, default: 'false'}\n- network: {mode: export, if: $(var lan)}\n"
      "- network: {mode: local, unless: $(var lan)}";
  EXPECT_EQ(network_of(file).mode, NetworkMode::Local);
  EXPECT_EQ(network_of(file, {{"lan", "true"}}).mode, NetworkMode::Export);
}

TEST(Network, has_security_in_sros2s_words) {
  const auto security =
      network_of("- network: {security: {keystore: keys, enclave: /robot, strategy: Permissive}}").security;
  ASSERT_TRUE(security);
  EXPECT_EQ(security->keystore, "keys") << "beside the launch file";
  EXPECT_EQ(security->enclave, "/robot");
  EXPECT_FALSE(security->enforced);
  EXPECT_TRUE(network_of("- network: {security: {keystore: /etc/keys}}").security->enforced)
      << "enforced is the default";
  EXPECT_FALSE(network_of("- network: {mode: local}").security);
}

TEST(Network, is_part_of_the_plans_text) {
  const auto plan =
      load_network("- network: {mode: export, domain_id: 3, peers: [a], export: [{topic: /scan, max_hz: 5}]}");
  ASSERT_TRUE(plan) << problems_of(plan);
  EXPECT_NE(
      to_text(*plan).find("network export domain 3 interfaces [] peers [a]\n  export /scan max_hz 5.0 max_bytes 0"),
      std::string::npos)
      << to_text(*plan);
}

TEST(Network, tells_each_mistake_with_its_line) {
  struct Case {
    const char* text;
    const char* told;
  };
  const Case cases[]{
      {"- network: {mode: expert}", "a.launch.yaml:2: 'mode' cannot be 'expert'; did you mean 'export'?\n"},
      {"- network: {domain_id: 233}", "a.launch.yaml:2: 'domain_id' must be a whole number from 0 to 232, not '233'\n"},
      {"- network: {domain: 3}", "a.launch.yaml:2: unknown key 'domain' in 'network'; did you mean 'domain_id'?\n"},
      {"- network: {peers: ['a b']}", "a.launch.yaml:2: the peer 'a b' is not an address; a host name or an address\n"},
      {"- network:\n    interfaces:\n    - 'eth0\"'",
       "a.launch.yaml:3: 'eth0\"' is not an interface; a name from `ip link`, or an address\n"},
      {"- network: {allow_load: perhaps}", "a.launch.yaml:2: 'allow_load' must be true or false, not 'perhaps'\n"},
      {"- network: {export: [{topic: /a-b}]}",
       "a.launch.yaml:2: the topic or service name '/a-b' may hold only letters, digits, '_' and '/'\n"},
      {"- network: {export: [{max_hz: 3}]}", "a.launch.yaml:2: 'export' needs the key 'topic'\n"},
      {"- network: {export: [{topic: /a, max_hz: 0}]}",
       "a.launch.yaml:2: 'max_hz' must be a number above 0, not '0'; leave it out for every message\n"},
      {"- network: {export: []}",
       "a.launch.yaml:2: an empty list of exports shows nothing; leave it out to export every topic, or take mode: "
       "local\n"},
      {"- network: {export: [{topic: /a, max_bytes: 0}]}",
       "a.launch.yaml:2: 'max_bytes' of 0 lets nothing through; leave the topic out of the list, or leave the limit "
       "out\n"},
      {"- network: {export: [{topic: /a}, {topic: /a}]}",
       "a.launch.yaml:2: the topic '/a' is exported a second time; the first is at a.launch.yaml:2\n"},
      {"- network: {security: {enclave: robot}}",
       "a.launch.yaml:2: as an enclave: the namespace 'robot' is not absolute: it must start with '/'\n"},
      {"- network: {security: {strategy: enforce}}",
       "a.launch.yaml:2: 'strategy' cannot be 'enforce'; did you mean 'Enforce'?\n"},
      {"- network: {security: {keys: a}}",
       "a.launch.yaml:2: unknown key 'keys' in 'security'; one of keystore, enclave, strategy\n"},
      {"- network: {mode: local}\n- network: {mode: off}",
       "a.launch.yaml:3: a second 'network'; the first is at a.launch.yaml:2; a container has one network: put both "
       "into one, or give them `if`\n"},
  };
  for (const auto& [text, expected] : cases) EXPECT_EQ(mistakes_of(text), expected) << text;
  EXPECT_EQ(mistakes_of("- log: {message: a}", {{"network", "lokal"}}),
            "network:=lokal: 'lokal' is not a mode of the network; did you mean 'local'?\n");
}

}  // namespace
}  // namespace nacelle::launch
