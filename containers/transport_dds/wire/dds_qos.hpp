// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "nacelle/base/time.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle::transport_dds {

// Values as in DDS's own enumerations, which is also how discovery has them (but for reliability, there 1 and 2).
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
  Duration lifespan = kDdsInfinite;  ///< Of writers only.
  DdsLiveliness liveliness = DdsLiveliness::Automatic;
  Duration lease = kDdsInfinite;
  /// A writer with TransientLocal: what it keeps for readers that come late is its DURABILITY_SERVICE, with cleanup
  /// delay zero, no resource limits, and the history and depth above.
  [[nodiscard]] bool has_durability_service() const { return durability != DdsDurability::Volatile; }
  /// WRITER_DATA_LIFECYCLE. Disposing of instances means nothing to ROS 2.
  bool autodispose_unregistered_instances = false;
  /// IGNORELOCAL_PARTICIPANT, Cyclone's: a reader that does not see the writers of its own participant.
  bool ignores_own_participant = false;

  friend bool operator==(const DdsQos&, const DdsQos&) = default;
};

/// Nacelle's words to DDS's. What is left of system_default and best_available is made concrete as resolved() does it;
/// unknown is taken as system_default: the caller has checked. Source: create_readwrite_qos,
/// rmw_cyclonedds_cpp/src/rmw_node.cpp (jazzy).
[[nodiscard]] DdsQos to_dds(const QoS& given);
/// DDS's words, of a remote endpoint, to Nacelle's; what ROS 2 cannot say becomes Unknown. KEEP_ALL has depth 0.
/// Source: dds_qos_to_rmw_qos, in the same file.
[[nodiscard]] QoS from_dds(const DdsQos& dds);

/// ros_discovery_info's QoS. Source: rmw_context_impl_s::init, in the same file.
[[nodiscard]] DdsQos discovery_writer_qos();
[[nodiscard]] DdsQos discovery_reader_qos();

/// DDS's numbers of policies, as an INCOMPATIBLE_QOS status names them.
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
/// "reliability", "durability", ... as EndpointStatus::last_policy has them; "unknown policy" for any other number.
[[nodiscard]] std::string_view policy_name(DdsPolicy policy);
/// The policy that keeps a writer and a reader apart; Invalid if they match. Of several, the one that Cyclone names.
/// Source: OMG DDS 1.4 section 2.2.3, requested against offered; the order of qos_match_mask_p (Cyclone 0.10).
[[nodiscard]] DdsPolicy incompatible_policy(const DdsQos& offered, const DdsQos& requested);

}  // namespace nacelle::transport_dds
