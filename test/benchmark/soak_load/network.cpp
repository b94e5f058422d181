// SPDX-License-Identifier: Apache-2.0
#include "network.hpp"

#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "nacelle/msgs/message_type.hpp"
#include "nacelle/transport_dds/mirror.hpp"
#include "support/own_network.hpp"
#include "transport_dds/port/discovery.hpp"
#include "transport_dds/port/participant.hpp"
#include "transport_dds/port/reader.hpp"

namespace nacelle::soak {
namespace {

namespace dds = transport_dds;

// Participants of one process have a domain each; on the network they share one that no other process has.
std::string config() {
  return R"(<General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces></General>)"
         "<Discovery><ExternalDomainId>" +
         std::to_string(100 + ::getpid() % 100) + "</ExternalDomainId></Discovery>";
}
constexpr Duration kStep = 100us, kUnchanged = 500ms, kPatience = 20s;

[[noreturn]] void end_program(const std::string& why) {
  std::fprintf(stderr, "soak-load: %s\n", why.c_str());
  std::exit(1);
}

/// A participant beside the container's.
class Peer {
 public:
  explicit Peer(std::uint32_t number) {
    auto made = dds::Participant::create({.domain_id = number, .config = config()});
    if (!made) end_program(made.error().text());
    participant_ = std::move(*made);
    auto discovery = participant_->create_discovery(nullptr);
    if (!discovery) end_program(discovery.error().text());
    discovery_ = std::move(*discovery);
    const msgs::MessageType& type = std_msgs::msg::String::message_type();
    for (const char* const topic : {"rt/echo", "rt/latched"}) {
      dds::EndpointOptions options{topic, type.dds_name, type.hash, dds::to_dds(QoS(10)), {}};
      auto reader = participant_->create_reader(options, nullptr);
      if (!reader) end_program(reader.error().text());
      readers_.push_back(std::move(*reader));
    }
  }
  /// Endpoints that it knows, those of all peers included.
  [[nodiscard]] std::size_t known() {
    while (discovery_->take(events_, 100)) {}
    for (const dds::DiscoveryEvent& event : events_) {
      const auto* const end = std::get_if<dds::DiscoveredEndpoint>(&event.what);
      if (end == nullptr) continue;
      if (event.kind == dds::DiscoveryEvent::Kind::Appeared) ++known_;
      if (event.kind == dds::DiscoveryEvent::Kind::Gone) --known_;
    }
    events_.clear();
    return known_;
  }

 private:
  std::unique_ptr<dds::Participant> participant_;
  std::unique_ptr<dds::Discovery> discovery_;
  std::vector<std::unique_ptr<dds::Reader>> readers_;
  std::vector<dds::DiscoveryEvent> events_;
  std::size_t known_ = 0;
};

}  // namespace

struct SoakNetwork::Impl {
  std::unique_ptr<DdsMirror> mirror;
  std::vector<std::unique_ptr<Peer>> peers;
  std::array<std::vector<std::size_t>, 2> seen;  // by composition: the container's endpoints, then what each peer knows

  [[nodiscard]] std::vector<std::size_t> counts() {
    const MirrorStats stats = mirror->stats();
    std::vector<std::size_t> all{stats.writers + stats.readers + 2 * (stats.servers + stats.clients)};
    for (const auto& peer : peers) all.push_back(peer->known());
    return all;
  }
};

void SoakNetwork::enter() { static_cast<void>(test::enter_own_network()); }

SoakNetwork::SoakNetwork(runtime::Container& container, const Clock& clock, std::size_t peers)
    : impl_(std::make_unique<Impl>()) {
  MirrorOptions options;
  options.domain_id = 7;
  options.config = config();
  auto made = DdsMirror::start(container.graph(), clock, options, &container.service_graph());
  if (!made) end_program(made.error().text());
  impl_->mirror = std::move(*made);
  for (std::size_t i = 0; i < peers; ++i)
    impl_->peers.push_back(std::make_unique<Peer>(static_cast<std::uint32_t>(8 + i)));
}

SoakNetwork::~SoakNetwork() = default;

void SoakNetwork::await(With composition) {
  auto& wanted = impl_->seen[static_cast<std::size_t>(composition)];
  Duration unchanged{};
  if (wanted.empty()) {
    for (auto last = impl_->counts(); unchanged < kUnchanged; unchanged += kStep) {
      std::this_thread::sleep_for(kStep);
      if (auto now = impl_->counts(); now != last) last = std::move(now), unchanged = {};
    }
    wanted = impl_->counts();
    return;
  }
  for (Duration waited{}; impl_->counts() != wanted; waited += kStep) {
    if (waited > kPatience) end_program("a peer has not seen all endpoints, or not their end, within 20 s");
    std::this_thread::sleep_for(kStep);
  }
}

std::size_t SoakNetwork::endpoints(With composition) const {
  const auto& seen = impl_->seen[static_cast<std::size_t>(composition)];
  return seen.empty() ? 0 : seen.front();
}

}  // namespace nacelle::soak
