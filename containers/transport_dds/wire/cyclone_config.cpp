// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/cyclone_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "nacelle/base/expect.hpp"
#include "nacelle/base/xml.hpp"

namespace nacelle::transport_dds {
namespace {

bool is_address(std::string_view text) {
  return text.find(':') != std::string_view::npos || text.find_first_not_of("0123456789.") == std::string_view::npos;
}

std::string interfaces_of(const NetworkSettings& settings) {
  std::string all;
  // Said to do multicast, lo has no limit of ten processes.
  for (const auto& name : settings.interfaces) {
    all += fmt::format(R"(<NetworkInterface {}="{}"{}/>)", is_address(name) ? "address" : "name", xml_escaped(name),
                       name == "lo" ? R"( multicast="true")" : "");
  }
  return all.empty() ? all : "<Interfaces>" + all + "</Interfaces>";
}

std::string general_of(const NetworkSettings& settings) {
  std::string general;
  // Joining a group on the LAN's interface announces it to the LAN. port/this_machine.cpp does without.
  if (settings.discovery == Reach::ThisMachine)
    general += fmt::format("<MulticastRecvNetworkInterfaceAddresses>{}</MulticastRecvNetworkInterfaceAddresses>",
                           settings.interfaces.empty() ? "none" : "127.0.0.1");
  general += interfaces_of(settings);
  if (settings.discovery == Reach::Unicast) general += "<AllowMulticast>false</AllowMulticast>";
  // Datagrams as large as lo carries, which is where all goes that stays on this machine: in Cyclone's own of 1.5 kB a message of
  // megabytes drowns. Elsewhere one in a frame of Ethernet (IPv6's header taken off): of larger ones the pieces that arrive
  // fill the kernel's memory for reassembly when others are lost, and then not even a scan arrives.
  general += settings.discovery == Reach::ThisMachine
                 ? "<MaxMessageSize>65500B</MaxMessageSize><FragmentSize>65000B</FragmentSize>"
                 : "<MaxMessageSize>1452B</MaxMessageSize>";
  return "<General>" + general + "</General>";
}

std::string discovery_of(const NetworkSettings& settings) {
  // A number, so that the ports are those that a firewall and others' static peers expect.
  std::string discovery =
      fmt::format("<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>{}</MaxAutoParticipantIndex>",
                  kMostParticipantIndex);
  // On this machine in both ways: with multicast, and as rmw_cyclonedds does for the range LOCALHOST, so that its tools
  // find this process without knowing its settings.
  const bool asks_this_machine = settings.discovery == Reach::Unicast || settings.discovery == Reach::ThisMachine;
  std::string peers = asks_this_machine ? R"(<Peer address="localhost"/>)" : "";
  for (const auto& peer : settings.peers) peers += fmt::format(R"(<Peer address="{}"/>)", xml_escaped(peer));
  if (!peers.empty()) discovery += "<Peers>" + peers + "</Peers>";
  return "<Discovery>" + discovery + "</Discovery>";
}

}  // namespace

std::string cyclone_config(const NetworkSettings& settings) {
  NACELLE_EXPECT(settings.mode != NetworkMode::Off, "a network that is off has no configuration");
  std::string config =
      "<CycloneDDS><Domain>" + general_of(settings) + discovery_of(settings) + "</Domain></CycloneDDS>";
  if (!settings.cyclonedds_uri.empty()) config += "," + settings.cyclonedds_uri;
  return config;
}

PortRange ports_of_domain(int domain, int most_index) {
  const int first = 7400 + 250 * domain;
  return {first, first + 11 + 2 * most_index};
}

std::vector<PortRange> parse_port_ranges(std::string_view text) {
  std::vector<PortRange> ranges;
  const char *at = text.data(), *const end = at + text.size();
  while (at != end) {
    PortRange range;
    auto read = std::from_chars(at, end, range.first);
    if (read.ec == std::errc{}) {
      range.last = range.first;
      if (read.ptr != end && *read.ptr == '-') read = std::from_chars(read.ptr + 1, end, range.last);
      if (read.ec == std::errc{}) ranges.push_back(range);
    }
    at = std::find(at, end, ',');
    if (at != end) ++at;
  }
  return ranges;
}

std::optional<Problem> port_remark(int domain, const PortRange& ephemeral, const std::vector<PortRange>& reserved) {
  const PortRange ports = ports_of_domain(domain);
  const auto holds = [](const PortRange& range, int port) { return range.first <= port && port <= range.last; };
  bool is_given = false;
  for (int port = ports.first; port <= ports.last; ++port) {
    is_given |= holds(ephemeral, port) && std::none_of(reserved.begin(), reserved.end(),
                                                       [&](const PortRange& range) { return holds(range, port); });
  }
  if (!is_given) return std::nullopt;
  return Problem{
      fmt::format("domain {}", domain),
      fmt::format("its UDP ports {} to {} reach those from {} to {} that the kernel gives to any program", ports.first,
                  ports.last, ephemeral.first, ephemeral.last),
      fmt::format("take another domain, or `sysctl net.ipv4.ip_local_reserved_ports={}-{}`", ports.first, ports.last)};
}

}  // namespace nacelle::transport_dds
