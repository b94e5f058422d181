// SPDX-License-Identifier: Apache-2.0
#include "networking/network_wish.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "nacelle/base/problem_json.hpp"
#include "nacelle/base/time.hpp"
#include "networking/network_links.hpp"
#include "transport_dds/wire/cyclone_config.hpp"
#ifdef NACELLE_HAS_SECURITY
#include "security/enclave.hpp"
#endif

namespace nacelle::networking {
namespace {

using nlohmann::json;
using transport_dds::NetworkMode;

// Cyclone 0.10 takes four interfaces, of which one is lo (MAX_XMIT_CONNS).
constexpr std::size_t kMostOnTheLan = 3;

transport_dds::NetworkWish wish_of(const launch::NetworkPlan& plan) {
  transport_dds::NetworkWish wish;
  if (plan.mode) wish.mode = static_cast<NetworkMode>(*plan.mode);
  wish.domain_id = plan.domain_id;
  wish.interfaces = plan.interfaces;
  wish.peers = plan.peers;
  wish.allow_load = plan.allow_load;
  wish.remote_control = plan.remote_control;
  if (plan.security) wish.security = {true, plan.security->enforced, plan.security->keystore, plan.security->enclave};
  for (const auto& one : plan.exports)
    wish.exports.push_back({one.topic, one.max_hz, static_cast<std::size_t>(one.max_bytes_per_s), one.compressed_only});
  return wish;
}

/// Linux' own numbers where they cannot be read.
transport_dds::PortRange ephemeral_ports() {
  transport_dds::PortRange range{32768, 60999};
  std::ifstream{"/proc/sys/net/ipv4/ip_local_port_range"} >> range.first >> range.last;
  return range;
}

std::vector<transport_dds::PortRange> reserved_ports() {
  std::string text;
  std::getline(std::ifstream{"/proc/sys/net/ipv4/ip_local_reserved_ports"}, text);
  return transport_dds::parse_port_ranges(text);
}

const char* to_text(transport_dds::Reach discovery) {
  constexpr std::array<const char*, 5> kWords{"none", "this machine", "unicast", "multicast", "as configured"};
  return kWords[static_cast<std::size_t>(discovery)];
}

Result<void, Problem> secure(transport_dds::NetworkSettings& settings, WallTime now) {
#ifdef NACELLE_HAS_SECURITY
  auto enclave = security::open_enclave(settings.security, settings.domain, now);
  if (!enclave) return err(enclave.error());
  settings.secured = std::move(enclave.value().secured);
  for (auto& remark : enclave.value().remarks) settings.remarks.push_back(std::move(remark));
  return {};
#else
  static_cast<void>(settings);
  static_cast<void>(now);
  return err(security_is_not_built_in("security"));
#endif
}

Result<void, Problem> obey_security(transport_dds::NetworkSettings& settings, WallTime now) {
  if (!settings.security.enabled) return {};
  auto secured = secure(settings, now);
  if (secured || settings.security.enforced) return secured;
  Problem problem = secured.error();
  problem.what += ": everything goes in the clear, as the strategy Permissive allows";
  settings.remarks.push_back(std::move(problem));
  return {};
}

json json_of(const transport_dds::SecurityWish& asked, const std::optional<transport_dds::SecuredBy>& had) {
  if (!asked.enabled) return nullptr;
  json words{{"strategy", transport_dds::strategy_of(asked)},
             {"keystore", asked.keystore},
             {"enclave", asked.enclave.empty() ? "/" : asked.enclave},
             {"in_force", had.has_value()},
             {"subject", nullptr},
             {"ends", nullptr}};
  if (had) {
    words["subject"] = had->subject;
    words["ends"] = had->ends;
  }
  return words;
}

}  // namespace

bool network_is_built_in() {
#ifdef NACELLE_HAS_DDS
  return true;
#else
  return false;
#endif
}

Problem network_is_not_built_in(const Place& where) {
  return {where, "this program was built without Cyclone DDS: it cannot be on a network",
          "install cyclonedds-dev and build again, or network:=off"};
}

Problem security_is_not_built_in(const Place& where) {
  return {where, "this program was built without OpenSSL's library: there is no security",
          "install libssl-dev and build again"};
}

transport_dds::Environment ros_environment() {
  transport_dds::Environment found;
  for (char** at = ::environ; at != nullptr && *at != nullptr; ++at) {
    const std::string_view entry{*at};
    const auto equals = entry.find('=');
    if (equals == std::string_view::npos) continue;
    for (const std::string_view beginning : {"ROS_", "RMW_", "CYCLONEDDS_"}) {
      if (entry.starts_with(beginning)) found.emplace(entry.substr(0, equals), entry.substr(equals + 1));
    }
  }
  return found;
}

Result<transport_dds::NetworkSettings, Problem> network_in_force(const launch::NetworkPlan& plan,
                                                                 const transport_dds::Environment& environment,
                                                                 const Clock& clock) {
  auto settings = transport_dds::network_settings(wish_of(plan), environment);
  if (!settings) return settings;
  if (plan.mode && plan.mode_by_argument) settings->because_of = std::string("network:=") + to_text(*plan.mode);
  if (settings->mode == NetworkMode::Off) return settings;
  if (auto obeyed = obey_security(*settings, clock.wall_now()); !obeyed) return err(obeyed.error());
  if (settings->discovery == transport_dds::Reach::ThisMachine) {
    auto lan = addresses_on_the_lan();
    lan.resize(std::min(lan.size(), kMostOnTheLan));
    settings->interfaces.insert(settings->interfaces.end(), lan.begin(), lan.end());
  }
  if (auto remark = transport_dds::port_remark(settings->domain, ephemeral_ports(), reserved_ports()))
    settings->remarks.push_back(std::move(*remark));
  return settings;
}

std::string network_off_line(const Problem& why) {
  return "network: off, since " + why.text() + "; the robot runs without it";
}

json json_of(const transport_dds::NetworkSettings& settings) {
  json exports = json::array(), remarks = json::array();
  for (const auto& rule : settings.exports) {
    exports.push_back({{"topic", rule.topic},
                       {"max_hz", rule.max_hz == 0 ? json(nullptr) : json(rule.max_hz)},
                       {"max_bytes", rule.max_bytes_per_s == 0 ? json(nullptr) : json(rule.max_bytes_per_s)},
                       {"compressed_only", rule.compressed_only}});
  }
  for (const auto& remark : settings.remarks) remarks.push_back(remark);
  const auto ports = transport_dds::ports_of_domain(settings.domain);
  return {{"mode", transport_dds::to_text(settings.mode)},
          {"because_of", settings.because_of},
          {"discovery", to_text(settings.discovery)},
          {"domain", settings.domain},
          {"ports", {{"first", ports.first}, {"last", ports.last}}},
          {"interfaces", settings.interfaces},
          {"peers", settings.peers},
          {"exports", std::move(exports)},
          {"allow_load", settings.allow_load},
          {"remote_control", settings.remote_control},
          {"security", json_of(settings.security, settings.secured)},
          {"cyclonedds_uri", settings.cyclonedds_uri},
          {"remarks", std::move(remarks)},
          {"line", transport_dds::network_line(settings)}};
}

}  // namespace nacelle::networking
