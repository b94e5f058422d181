// SPDX-License-Identifier: Apache-2.0
// Peers that announce anything, in any order: the cache stays within its limits, what it shows is fit for a terminal,
// and when all have gone nothing is left.
//
//   input: records of  u8 what (0 participant, 1 endpoint, 2 snapshot, 3 endpoint gone, 4 participant gone), u8 peer,
//                      u8 entity, u16 little-endian length, bytes
//   bytes: USER_DATA of a participant; topic NUL type NUL USER_DATA of an endpoint; the payload of a snapshot
#include <algorithm>

#include "nacelle/base/expect.hpp"
#include "nacelle/base/names.hpp"
#include "transport_dds/wire/remote_graph.hpp"

namespace {

using namespace nacelle;
using namespace nacelle::transport_dds;

constexpr RemoteGraphLimits kLimits{4, 12, 6, 8, 4, 64, 4096};

Gid peer(std::uint8_t number) {
  // Peer 0 is the participant of the recorded snapshots among the seeds.
  Gid gid{{0x01, 0x10, 0x0F, 0x26, 0xB6, 0xE0, 0x33, 0xD4, 0x7C, 0xC8, 0xD6, 0xF7}};
  gid.bytes[11] = static_cast<std::uint8_t>(gid.bytes[11] + number);
  return gid.participant();
}
Gid entity(std::uint8_t of, std::uint8_t number) {
  Gid gid = peer(of);
  gid.bytes[12] = gid.bytes[13] = 0;
  gid.bytes[14] = number;
  gid.bytes[15] = number % 2 == 0 ? 0x03 : 0x04;
  return gid;
}

std::string_view cut(std::string_view& text) {
  const auto end = std::min(text.find('\0'), text.size());
  const std::string_view word = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return word;
}

DiscoveredEndpoint endpoint(const Gid& gid, ByteView bytes) {
  std::string_view rest = as_text(bytes);
  DiscoveredEndpoint made{gid, gid.participant(), gid.bytes[15] == 0x03, {}, {}, {}, {}};
  made.topic = cut(rest);
  made.type = cut(rest);
  made.user_data.assign(rest.begin(), rest.end());
  // Odd policies as well.
  made.qos.depth = static_cast<std::int32_t>(bytes.size()) - 20;
  made.qos.deadline = Duration{made.qos.depth};
  return made;
}

bool is_shown(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

void check_limits(const RemoteGraph& graph) {
  const auto nodes = graph.nodes();
  NACELLE_EXPECT(nodes.size() <= kLimits.nodes, "nodes are bounded");
  for (const auto& node : nodes) {
    NACELLE_EXPECT(validate_node_name(node.name) && validate_namespace(node.node_namespace), "a node has a name");
    NACELLE_EXPECT(is_shown(node.enclave), "an enclave is shown");
    NACELLE_EXPECT(graph.node(node.node_namespace, node.name).has_value(), "a node that is listed can be asked for");
  }
  std::size_t ends = 0;
  const auto check = [&](const RemoteEndpoint& one) {
    NACELLE_EXPECT(is_shown(one.type), "a type is shown");
    NACELLE_EXPECT(graph.endpoint(one.gid).has_value(), "an endpoint that is listed can be asked for");
    ++ends;
  };
  for (const auto& [name, types] : graph.topics()) {
    NACELLE_EXPECT(validate_full_topic_name(name), "a topic has a name");
    for (const auto& one : graph.ends_of_topic(name)) check(one);
  }
  for (const auto& [name, types] : graph.services()) {
    NACELLE_EXPECT(validate_full_topic_name(name), "a service has a name");
    for (const auto& one : graph.ends_of_service(name)) check(one);
  }
  NACELLE_EXPECT(ends <= kLimits.endpoints, "endpoints are bounded");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHead = 5;
  RemoteGraph graph{peer(0xFF), kLimits};
  ByteView rest{data, size};
  while (rest.size() >= kHead) {
    const std::uint8_t of = rest[1];
    const Gid gid = entity(of, rest[2]);
    const ByteView bytes = rest.subspan(kHead, std::min<std::size_t>(load_le16(&rest[3]), rest.size() - kHead));
    switch (rest[0] % 5) {
      case 0: graph.participant_is_there({peer(of), Bytes(bytes.begin(), bytes.end()), "a\x1b", "", ""}); break;
      case 1: graph.endpoint_is_there(endpoint(gid, bytes)); break;
      case 2: graph.snapshot_came(gid, bytes); break;
      case 3: graph.endpoint_has_gone(gid); break;
      default: graph.participant_has_gone(peer(of)); break;
    }
    rest = rest.subspan(kHead + bytes.size());
    check_limits(graph);
  }
  for (int of = 0; of < 256; ++of) graph.participant_has_gone(peer(static_cast<std::uint8_t>(of)));
  NACELLE_EXPECT(graph.nodes().empty() && graph.topics().empty() && graph.services().empty(), "nothing is left");
  return 0;
}
