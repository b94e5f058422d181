// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/discovery.hpp"

#include <algorithm>
#include <array>

#include "transport_dds/port/core.hpp"
#include "transport_dds/port/cyclone_log.hpp"
#include "transport_dds/port/cyclone_qos.hpp"

namespace nacelle::transport_dds {
namespace {

constexpr std::array<dds_entity_t, 3> kTopics{DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, DDS_BUILTIN_TOPIC_DCPSPUBLICATION,
                                              DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION};
constexpr std::size_t kAtOnce = 16;

DiscoveryEvent::Kind kind_of(const dds_sample_info_t& info) {
  if (!info.valid_data || info.instance_state != DDS_IST_ALIVE) return DiscoveryEvent::Kind::Gone;
  return info.view_state == DDS_VST_NEW ? DiscoveryEvent::Kind::Appeared : DiscoveryEvent::Kind::Changed;
}

DiscoveryEvent event_of(const void* sample, const dds_sample_info_t& info, std::size_t topic) {
  DiscoveryEvent out{kind_of(info), DiscoveredParticipant{}};
  const bool gone = out.kind == DiscoveryEvent::Kind::Gone;  // then only the key is there
  if (topic == 0) {
    const auto& found = *static_cast<const dds_builtintopic_participant_t*>(sample);
    out.what = gone ? DiscoveredParticipant{to_gid(found.key), {}, {}, {}, {}} : to_participant(found);
    return out;
  }
  const auto& found = *static_cast<const dds_builtintopic_endpoint_t*>(sample);
  DiscoveredEndpoint endpoint;
  if (gone) {
    endpoint.gid = to_gid(found.key);
    endpoint.participant = endpoint.gid.participant();
    endpoint.is_writer = topic == 1;
  } else {
    endpoint = to_endpoint(found, topic == 1);
  }
  out.what = std::move(endpoint);
  return out;
}

}  // namespace

struct Discovery::Impl {
  std::shared_ptr<ParticipantCore> core;
  DiscoveryListener* listener = nullptr;
  std::array<Entity, kTopics.size()> readers;  // their listeners use the members above
};

Result<std::unique_ptr<Discovery>, Problem> Discovery::create(std::shared_ptr<ParticipantCore> core,
                                                              DiscoveryListener* listener) {
  auto impl = std::make_unique<Impl>();
  impl->core = std::move(core);
  impl->listener = listener;
  const CycloneListener told{dds_create_listener(listener)};
  if (listener != nullptr) {
    dds_lset_data_available(told.get(),
                            [](dds_entity_t, void* to) { static_cast<DiscoveryListener*>(to)->on_discovery(); });
  }
  const CapturedLog log;
  for (std::size_t i = 0; i < kTopics.size(); ++i) {
    impl->readers[i] = Entity{dds_create_reader(impl->core->participant.get(), kTopics[i], nullptr, told.get())};
    if (!impl->readers[i]) return err(Problem{"DDS discovery", error_name(impl->readers[i].get()), log.text()});
  }
  return std::unique_ptr<Discovery>(new Discovery(std::move(impl)));
}

Discovery::Discovery(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Discovery::~Discovery() = default;

bool Discovery::take(std::vector<DiscoveryEvent>& out, std::size_t most) {
  std::size_t taken = 0;
  for (std::size_t topic = 0; topic < kTopics.size(); ++topic) {
    for (;;) {
      if (taken >= most) return true;
      std::array<void*, kAtOnce> samples{};  // null: Cyclone lends its own
      std::array<dds_sample_info_t, kAtOnce> infos{};
      const auto room = static_cast<std::uint32_t>(std::min(kAtOnce, most - taken));
      const dds_entity_t reader = impl_->readers[topic].get();
      const dds_return_t count = dds_take(reader, samples.data(), infos.data(), kAtOnce, room);
      for (dds_return_t i = 0; i < count; ++i) out.push_back(event_of(samples[i], infos[i], topic));
      if (count > 0) {
        dds_return_loan(reader, samples.data(), count);
        taken += static_cast<std::size_t>(count);
      }
      if (count < static_cast<dds_return_t>(room)) break;
    }
  }
  return false;
}

Result<std::unique_ptr<Discovery>, Problem> Participant::create_discovery(DiscoveryListener* listener) {
  return Discovery::create(core_, listener);
}

}  // namespace nacelle::transport_dds
