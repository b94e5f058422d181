// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/ros_environment.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <utility>

#include "transport_dds/wire/network_fault.hpp"

namespace nacelle::transport_dds {
namespace {

struct RangeWord {
  std::string_view word;
  DiscoveryRange range;
};
constexpr std::array<RangeWord, 4> kRanges{{{"OFF", DiscoveryRange::Off},
                                            {"LOCALHOST", DiscoveryRange::Localhost},
                                            {"SUBNET", DiscoveryRange::Subnet},
                                            {"SYSTEM_DEFAULT", DiscoveryRange::SystemDefault}}};

// Obeyed, by this file or by another part (ROS_HOME: the camera's calibration).
const std::vector<std::string> kObeyed{
    "ROS_DOMAIN_ID",         "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS",
    "ROS_LOCALHOST_ONLY",    "ROS_SECURITY_ENABLE",           "ROS_SECURITY_STRATEGY",
    "ROS_SECURITY_KEYSTORE", "ROS_SECURITY_ENCLAVE_OVERRIDE", "ROS_HOME",
    "RMW_IMPLEMENTATION"};

// Variables that only describe a ROS 2 installation.
constexpr std::array<std::string_view, 6> kDescriptions{"ROS_DISTRO",       "ROS_VERSION", "ROS_PYTHON_VERSION",
                                                        "ROS_PACKAGE_PATH", "ROS_ROOT",    "ROS_ETC_DIR"};

struct Answer {
  std::string_view name, what, way_out;
};
constexpr std::array<Answer, 11> kAnswers{{
    {"ROS_DISCOVERY_SERVER", "Fast DDS only",
     "give static peers instead: ROS_STATIC_PEERS, or network: {peers: [...]}"},
    {"ROS_SUPER_CLIENT", "Fast DDS only", "nothing to do: every participant here sees the whole graph"},
    {"ROS_DISABLE_LOANED_MESSAGES", "not needed", "loans stay in the process, and what leaves it is a copy"},
    {"ROS_LOG_DIR", "no files of logs are written", "the journal has them, or redirect the standard error"},
    {"ROS_NAMESPACE", "ROS 1's", "the launch file's push_ros_namespace does it"},
    {"ROS_MASTER_URI", "ROS 1's", "nothing to do: there is no master"},
    {"ROS_IP", "ROS 1's", "network: {interfaces: [...]} in the launch file does it"},
    {"ROS_HOSTNAME", "ROS 1's", "network: {interfaces: [...]} in the launch file does it"},
    {"ROS_TRACE_DIR", "there is no tracing with LTTng", "`nacelle streams` and `nacelle top` show the times"},
    {"RMW_FASTRTPS_", "Fast DDS only", "CYCLONEDDS_URI configures the DDS that is used here"},
    {"RMW_CONNEXT_", "Connext only", "CYCLONEDDS_URI configures the DDS that is used here"},
}};

std::string value_of(const Environment& environment, std::string_view name) {
  const auto found = environment.find(name);
  return found == environment.end() ? std::string() : found->second;
}

// As strtoul() with base 0, which rcl uses: 42, 0x2a, 052. One that is below 0 or too large for an int is kMostDomain + 1.
std::optional<int> number_of(std::string_view text) {
  const bool is_negative = text.starts_with('-');
  if (is_negative) text.remove_prefix(1);
  int base = 10;
  if (text.starts_with("0x") || text.starts_with("0X")) {
    base = 16;
    text.remove_prefix(2);
  } else if (text.size() > 1 && text.starts_with('0')) {
    base = 8;
    text.remove_prefix(1);
  }
  int number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (read.ec == std::errc::invalid_argument || read.ptr != text.data() + text.size() || text.starts_with('-'))
    return std::nullopt;
  return read.ec != std::errc{} || is_negative ? kMostDomain + 1 : number;
}

std::string shown(std::string_view value) {
  std::string text(value.substr(0, 80));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return "'" + text + "'";
}

Result<std::optional<int>, Problem> read_domain(const std::string& text, std::vector<Problem>& remarks) {
  if (text.empty()) return std::optional<int>{};
  const auto number = number_of(text);
  if (!number)
    return err(Problem{"ROS_DOMAIN_ID", shown(text) + " is not a number",
                       "give a number from 0 to " + std::to_string(kMostDomain) + "; 0 to 101 work everywhere",
                       NetworkFault::WrongSetting, text});
  if (*number > kMostDomain) {
    return err(Problem{"ROS_DOMAIN_ID", shown(text) + " is not a domain",
                       "give a number from 0 to " + std::to_string(kMostDomain) + "; 0 to 101 work everywhere",
                       NetworkFault::WrongSetting, text});
  }
  if (text != std::to_string(*number)) {
    remarks.push_back({"ROS_DOMAIN_ID", shown(text) + " is read as " + std::to_string(*number) + ", as ROS 2 reads it",
                       "write " + std::to_string(*number)});
  }
  return number;
}

std::optional<DiscoveryRange> read_range(const std::string& text, std::vector<Problem>& remarks) {
  if (text.empty()) return std::nullopt;
  for (const auto& [word, range] : kRanges) {
    if (text == word) return range;
  }
  std::string upper = text;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  std::vector<std::string> words;
  words.reserve(kRanges.size());
  for (const auto& one : kRanges) words.emplace_back(one.word);
  remarks.push_back(
      {"ROS_AUTOMATIC_DISCOVERY_RANGE", shown(text) + " is not a range, LOCALHOST is taken", suggestion(upper, words)});
  return DiscoveryRange::Localhost;
}

std::vector<std::string> read_peers(std::string_view text, std::vector<Problem>& remarks) {
  std::vector<std::string> peers;
  while (!text.empty()) {
    const auto end = std::min(text.find(';'), text.size());
    const std::string_view peer = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (peer.empty()) continue;
    if (auto valid = validate_peer(peer); !valid) {
      remarks.push_back({"ROS_STATIC_PEERS", valid.error().what + ", and is ignored", valid.error().way_out});
    } else {
      peers.emplace_back(peer);
    }
  }
  return peers;
}

SecurityWish read_security(const Environment& environment, std::vector<Problem>& remarks) {
  SecurityWish wish;
  const std::string enable = value_of(environment, "ROS_SECURITY_ENABLE"),
                    strategy = value_of(environment, "ROS_SECURITY_STRATEGY");
  wish.enabled = enable == "true";
  if (!wish.enabled && !enable.empty() && enable != "false") {
    remarks.push_back({"ROS_SECURITY_ENABLE", shown(enable) + " switches nothing on", "write true"});
  }
  wish.enforced = wish.enabled && strategy == "Enforce";
  if (wish.enabled && !wish.enforced && !strategy.empty() && strategy != "Permissive") {
    remarks.push_back({"ROS_SECURITY_STRATEGY", shown(strategy) + " does not enforce security", "write Enforce"});
  }
  wish.keystore = value_of(environment, "ROS_SECURITY_KEYSTORE");
  wish.enclave = value_of(environment, "ROS_SECURITY_ENCLAVE_OVERRIDE");
  return wish;
}

void remark_on_middleware(const std::string& name, std::vector<Problem>& remarks) {
  if (name.empty() || name == "rmw_cyclonedds_cpp") return;
  if (name == "rmw_fastrtps_cpp" || name == "rmw_fastrtps_dynamic_cpp") {
    remarks.push_back({"RMW_IMPLEMENTATION", "topics work with " + name + ", services and actions do not",
                       "set it to rmw_cyclonedds_cpp on the other side"});
    return;
  }
  remarks.push_back({"RMW_IMPLEMENTATION", shown(name) + " does not see what this container announces",
                     "set it to rmw_cyclonedds_cpp on the other side"});
}

void remark_on_rest(const Environment& environment, std::vector<Problem>& remarks) {
  for (const auto& [name, value] : environment) {
    const bool is_ros = name.starts_with("ROS_") || name.starts_with("RMW_");
    const auto is = [&wanted = name](std::string_view known) { return known == wanted; };
    if (!is_ros || value.empty() || std::any_of(kObeyed.begin(), kObeyed.end(), is) ||
        std::any_of(kDescriptions.begin(), kDescriptions.end(), is)) {
      continue;
    }
    const auto answer = std::find_if(kAnswers.begin(), kAnswers.end(), [&set = name](const Answer& one) {
      return one.name.ends_with('_') ? set.starts_with(one.name) : set == one.name;
    });
    if (answer != kAnswers.end()) {
      remarks.push_back({name, std::string(answer->what), std::string(answer->way_out)});
    } else {
      const std::string meant = nearest_name(name, kObeyed);
      remarks.push_back({name, "nothing here reads it", meant.empty() ? "" : "did you mean " + meant + "?"});
    }
  }
}

}  // namespace

const char* to_text(DiscoveryRange range) {
  for (const auto& one : kRanges) {
    if (one.range == range) return one.word.data();
  }
  return "";
}

const char* strategy_of(const SecurityWish& wish) { return wish.enforced ? "Enforce" : "Permissive"; }

Result<EnvironmentWish, Problem> read_environment(const Environment& environment) {
  EnvironmentWish wish;
  auto domain = read_domain(value_of(environment, "ROS_DOMAIN_ID"), wish.remarks);
  if (!domain) return err(domain.error());
  wish.domain = *domain;
  wish.range = read_range(value_of(environment, "ROS_AUTOMATIC_DISCOVERY_RANGE"), wish.remarks);
  wish.peers = read_peers(value_of(environment, "ROS_STATIC_PEERS"), wish.remarks);
  const std::string localhost = value_of(environment, "ROS_LOCALHOST_ONLY");
  wish.localhost_only = localhost == "1";
  if (!localhost.empty()) {
    wish.remarks.push_back({"ROS_LOCALHOST_ONLY",
                            wish.localhost_only ? "deprecated, and obeyed: range and peers of the environment are not"
                                                : "deprecated, and switches nothing",
                            "ROS_AUTOMATIC_DISCOVERY_RANGE and ROS_STATIC_PEERS have taken its place"});
  }
  wish.cyclonedds_uri = value_of(environment, "CYCLONEDDS_URI");
  wish.security = read_security(environment, wish.remarks);
  remark_on_middleware(value_of(environment, "RMW_IMPLEMENTATION"), wish.remarks);
  remark_on_rest(environment, wish.remarks);
  return wish;
}

}  // namespace nacelle::transport_dds
