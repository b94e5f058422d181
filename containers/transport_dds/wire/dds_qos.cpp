// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/dds_qos.hpp"

#include <algorithm>
#include <limits>

namespace nacelle::transport_dds {
namespace {

// In QoS, zero means "not given", and best_available means that no concrete value was set.
Duration to_dds(Duration value) {
  return value == Duration::zero() || value >= kBestAvailableDuration ? kDdsInfinite : value;
}

// A peer may announce zero, a negative time or the number that means best_available; QoS knows none of them as a limit.
Duration from_dds(Duration value) {
  if (value >= kBestAvailableDuration) return Duration::zero();
  return std::max(value, Duration{1});
}

std::int32_t depth_of(std::size_t depth) {
  constexpr std::size_t kDeepest = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(std::clamp<std::size_t>(depth, 1, kDeepest));
}

}  // namespace

DdsQos to_dds(const QoS& given) {
  const QoS qos = given.resolved();
  DdsQos dds;
  if (qos.reliability() == Reliability::BestEffort) {
    dds.reliability = DdsReliability::BestEffort;
    dds.max_blocking = Duration::zero();
  }
  if (qos.durability() == Durability::TransientLocal) dds.durability = DdsDurability::TransientLocal;
  dds.history = qos.keeps_all() ? DdsHistory::KeepAll : DdsHistory::KeepLast;
  dds.depth = qos.keeps_all() ? kDdsUnlimited : depth_of(qos.depth());
  dds.deadline = to_dds(qos.deadline());
  dds.lifespan = to_dds(qos.lifespan());
  if (qos.liveliness() == Liveliness::ManualByTopic) dds.liveliness = DdsLiveliness::ManualByTopic;
  dds.lease = to_dds(qos.liveliness_lease_duration());
  return dds;
}

QoS from_dds(const DdsQos& dds) {
  QoS qos = dds.history == DdsHistory::KeepAll ? QoS(KeepAll{}) : QoS(static_cast<std::size_t>(std::max(dds.depth, 1)));
  qos.reliability(dds.reliability == DdsReliability::Reliable ? Reliability::Reliable : Reliability::BestEffort);
  switch (dds.durability) {
    case DdsDurability::Volatile: qos.durability(Durability::Volatile); break;
    case DdsDurability::TransientLocal: qos.durability(Durability::TransientLocal); break;
    case DdsDurability::Transient:
    case DdsDurability::Persistent: qos.durability(Durability::Unknown); break;
  }
  switch (dds.liveliness) {
    case DdsLiveliness::Automatic: qos.liveliness(Liveliness::Automatic); break;
    case DdsLiveliness::ManualByParticipant: qos.liveliness(Liveliness::Unknown); break;
    case DdsLiveliness::ManualByTopic: qos.liveliness(Liveliness::ManualByTopic); break;
  }
  qos.deadline(from_dds(dds.deadline)).lifespan(from_dds(dds.lifespan)).liveliness_lease_duration(from_dds(dds.lease));
  return qos;
}

DdsQos discovery_writer_qos() { return to_dds(QoS(1).transient_local()); }

DdsQos discovery_reader_qos() {
  DdsQos qos = to_dds(QoS(KeepAll{}).transient_local());
  qos.ignores_own_participant = true;
  return qos;
}

std::string_view policy_name(DdsPolicy policy) {
  switch (policy) {
    case DdsPolicy::Durability: return "durability";
    case DdsPolicy::Presentation: return "presentation";
    case DdsPolicy::Deadline: return "deadline";
    case DdsPolicy::LatencyBudget: return "latency_budget";
    case DdsPolicy::Ownership: return "ownership";
    case DdsPolicy::Liveliness: return "liveliness";
    case DdsPolicy::Partition: return "partition";
    case DdsPolicy::Reliability: return "reliability";
    case DdsPolicy::DestinationOrder: return "destination_order";
    case DdsPolicy::DataRepresentation: return "data_representation";
    case DdsPolicy::TypeConsistency: return "type_consistency";
    case DdsPolicy::Invalid: break;
  }
  return "unknown policy";
}

DdsPolicy incompatible_policy(const DdsQos& offered, const DdsQos& requested) {
  if (requested.reliability > offered.reliability) return DdsPolicy::Reliability;
  if (requested.durability > offered.durability) return DdsPolicy::Durability;
  if (requested.deadline < offered.deadline) return DdsPolicy::Deadline;
  if (requested.liveliness > offered.liveliness || requested.lease < offered.lease) return DdsPolicy::Liveliness;
  return DdsPolicy::Invalid;
}

}  // namespace nacelle::transport_dds
