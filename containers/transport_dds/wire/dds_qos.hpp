// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "nacelle/base/time.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle::transport_dds {

// The values are those of DDS's own enumerations. Discovery uses the same, except for reliability (1 and 2).
enum class DdsReliability : std::uint8_t { BestEffort = 0, Reliable = 1 };
enum class DdsDurability : std::uint8_t { Volatile = 0, TransientLocal = 1, Transient = 2, Persistent = 3 };
enum class DdsHistory : std::uint8_t { KeepLast = 0, KeepAll = 1 };
enum class DdsLiveliness : std::uint8_t { Automatic = 0, ManualByParticipant = 1, ManualByTopic = 2 };

/// DDS_INFINITY. Unlike in nacelle::QoS, zero means zero here.
inline constexpr Duration kDdsInfinite = Duration::max();
/// DDS_LENGTH_UNLIMITED
inline constexpr std::int32_t kDdsUnlimited = -1;

/// The policies of a DDS writer or reader that ROS 2 sets; all others have DDS's defaults, and resource limits are
/// none.
///
/// The defaults here are those of a ROS 2 endpoint. The data representation offered is XCDR1 only.
struct DdsQos {
  DdsReliability reliability = DdsReliability::Reliable;
  Duration max_blocking = kDdsInfinite;  ///< Infinite with Reliable, zero with BestEffort.
  DdsDurability durability = DdsDurability::Volatile;
  DdsHistory history = DdsHistory::KeepLast;
  std::int32_t depth = 1;  ///< At least 1 with KeepLast, kDdsUnlimited with KeepAll.
  Duration deadline = kDdsInfinite;
  Duration lifespan = kDdsInfinite;  ///< For writers only.
  DdsLiveliness liveliness = DdsLiveliness::Automatic;
  Duration lease = kDdsInfinite;
  /// Returns whether a writer sets DURABILITY_SERVICE, the history that it keeps for late joiners: cleanup delay zero,
  /// no resource limits, and the history and depth above.
  [[nodiscard]] bool has_durability_service() const { return durability != DdsDurability::Volatile; }
  /// WRITER_DATA_LIFECYCLE. ROS 2 does not use disposed instances.
  bool autodispose_unregistered_instances = false;
  /// Cyclone's IGNORELOCAL_PARTICIPANT: a reader ignores the writers of its own participant.
  bool ignores_own_participant = false;

  friend bool operator==(const DdsQos&, const DdsQos&) = default;
};

/// Converts a QoS to DDS's policies. Resolves remaining system_default and best_available values (QoS::resolved()), and
/// treats unknown as system_default; the caller checks for unknown.
/// Source: create_readwrite_qos, rmw_cyclonedds_cpp/src/rmw_node.cpp (jazzy).
[[nodiscard]] DdsQos to_dds(const QoS& given);
/// Converts the policies of a remote endpoint to a QoS. Values that ROS 2 does not have become Unknown. KEEP_ALL gets
/// depth 0. Source: dds_qos_to_rmw_qos, in the same file.
[[nodiscard]] QoS from_dds(const DdsQos& dds);

/// Returns the QoS of ros_discovery_info. Source: rmw_context_impl_s::init, in the same file.
[[nodiscard]] DdsQos discovery_writer_qos();
[[nodiscard]] DdsQos discovery_reader_qos();

/// DDS's policy ids, as used in an INCOMPATIBLE_QOS status.
enum class DdsPolicy : std::uint32_t {
  Invalid = 0,
  Durability = 2,
  Presentation = 3,
  Deadline = 4,
  LatencyBudget = 5,
  Ownership = 6,
  Liveliness = 8,
  Partition = 10,
  Reliability = 11,
  DestinationOrder = 12,
  DataRepresentation = 23,
  TypeConsistency = 24,
};
/// Returns "reliability", "durability" and so on, as in EndpointStatus::last_policy; "unknown policy" for any other id.
[[nodiscard]] std::string_view policy_name(DdsPolicy policy);
/// Returns the policy that makes a writer and a reader incompatible; Invalid if they match. Of several policies,
/// returns the one that Cyclone reports.
/// Source: OMG DDS 1.4 section 2.2.3, requested against offered; the order of qos_match_mask_p (Cyclone 0.10).
[[nodiscard]] DdsPolicy incompatible_policy(const DdsQos& offered, const DdsQos& requested);

}  // namespace nacelle::transport_dds
