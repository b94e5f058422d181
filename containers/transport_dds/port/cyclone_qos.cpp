// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/port/cyclone_qos.hpp"

#include <array>

namespace nacelle::transport_dds {
namespace {

static_assert(kDdsInfinite.count() == DDS_INFINITY);
static_assert(kDdsUnlimited == DDS_LENGTH_UNLIMITED);
static_assert(static_cast<int>(DdsDurability::TransientLocal) == DDS_DURABILITY_TRANSIENT_LOCAL);
static_assert(static_cast<int>(DdsReliability::Reliable) == DDS_RELIABILITY_RELIABLE);
static_assert(static_cast<int>(DdsHistory::KeepAll) == DDS_HISTORY_KEEP_ALL);
static_assert(static_cast<int>(DdsLiveliness::ManualByTopic) == DDS_LIVELINESS_MANUAL_BY_TOPIC);

template <typename To, typename From>
To as(From value) {
  return static_cast<To>(value);
}

DdsQos from_cyclone(const dds_qos_t* qos) {
  DdsQos out;
  dds_reliability_kind_t reliability{};
  dds_durability_kind_t durability{};
  dds_history_kind_t history{};
  dds_liveliness_kind_t liveliness{};
  dds_duration_t time = 0;
  std::int32_t depth = 0;
  bool flag = false;
  if (dds_qget_reliability(qos, &reliability, &time)) {
    out.reliability = as<DdsReliability>(reliability);
    out.max_blocking = Duration{time};
  }
  if (dds_qget_durability(qos, &durability)) out.durability = as<DdsDurability>(durability);
  if (dds_qget_history(qos, &history, &depth)) {
    out.history = as<DdsHistory>(history);
    out.depth = out.history == DdsHistory::KeepAll ? kDdsUnlimited : depth;
  }
  if (dds_qget_deadline(qos, &time)) out.deadline = Duration{time};
  if (dds_qget_lifespan(qos, &time)) out.lifespan = Duration{time};
  if (dds_qget_liveliness(qos, &liveliness, &time)) {
    out.liveliness = as<DdsLiveliness>(liveliness);
    out.lease = Duration{time};
  }
  if (dds_qget_writer_data_lifecycle(qos, &flag)) out.autodispose_unregistered_instances = flag;
  return out;
}

Bytes user_data_of(const dds_qos_t* qos) {
  void* data = nullptr;
  std::size_t size = 0;
  if (!dds_qget_userdata(qos, &data, &size) || data == nullptr) return {};
  Bytes bytes;
  if (size <= kMostUserData) bytes.assign(static_cast<std::uint8_t*>(data), static_cast<std::uint8_t*>(data) + size);
  dds_free(data);
  return bytes;
}

std::string property_of(const dds_qos_t* qos, const char* name) {
  char* value = nullptr;
  if (!dds_qget_prop(qos, name, &value) || value == nullptr) return {};
  std::string text = value;
  dds_free(value);
  return text;
}

}  // namespace

CycloneQos to_cyclone(const DdsQos& qos, ByteView user_data, bool is_writer) {
  CycloneQos out{dds_create_qos()};
  const auto history = as<dds_history_kind_t>(qos.history);
  dds_qset_reliability(out.get(), as<dds_reliability_kind_t>(qos.reliability), qos.max_blocking.count());
  dds_qset_durability(out.get(), as<dds_durability_kind_t>(qos.durability));
  dds_qset_history(out.get(), history, qos.depth);
  dds_qset_deadline(out.get(), qos.deadline.count());
  dds_qset_liveliness(out.get(), as<dds_liveliness_kind_t>(qos.liveliness), qos.lease.count());
  if (is_writer) {
    dds_qset_lifespan(out.get(), qos.lifespan.count());
    dds_qset_writer_data_lifecycle(out.get(), qos.autodispose_unregistered_instances);
    if (qos.has_durability_service())
      dds_qset_durability_service(out.get(), 0, history, qos.depth, kDdsUnlimited, kDdsUnlimited, kDdsUnlimited);
  }
  if (qos.ignores_own_participant) dds_qset_ignorelocal(out.get(), DDS_IGNORELOCAL_PARTICIPANT);
  constexpr std::array<dds_data_representation_id_t, 1> kRepresentations{DDS_DATA_REPRESENTATION_XCDR1};
  dds_qset_data_representation(out.get(), kRepresentations.size(), kRepresentations.data());
  if (!user_data.empty()) dds_qset_userdata(out.get(), user_data.data(), user_data.size());
  return out;
}

DiscoveredEndpoint to_endpoint(const dds_builtintopic_endpoint_t& found, bool is_writer) {
  DiscoveredEndpoint out;
  out.gid = to_gid(found.key);
  out.participant = to_gid(found.participant_key);
  out.is_writer = is_writer;
  if (found.topic_name != nullptr) out.topic = found.topic_name;
  if (found.type_name != nullptr) out.type = found.type_name;
  if (found.qos != nullptr) {
    out.qos = from_cyclone(found.qos);
    out.user_data = user_data_of(found.qos);
  }
  return out;
}

DiscoveredParticipant to_participant(const dds_builtintopic_participant_t& found) {
  DiscoveredParticipant out;
  out.gid = to_gid(found.key);
  if (found.qos != nullptr) {
    out.user_data = user_data_of(found.qos);
    out.process = property_of(found.qos, "__ProcessName");
    out.host = property_of(found.qos, "__Hostname");
    if (out.host.empty()) out.host = property_of(found.qos, "fastdds.physical_data.host");
    out.pid = property_of(found.qos, "__Pid");
  }
  return out;
}

}  // namespace nacelle::transport_dds
