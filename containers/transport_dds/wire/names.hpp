// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::transport_dds {

// ROS 2's names for DDS topics and types. Actions (three services and two topics) and service events (a topic) have no
// schemes of their own.
//
//   ROS 2                             DDS topic            DDS type
//   topic /a/b of pkg/msg/T           rt/a/b               pkg::msg::dds_::T_
//   request to /n/s of pkg/srv/S      rq/n/sRequest        pkg::srv::dds_::S_Request_
//   reply of /n/s                     rr/n/sReply          pkg::srv::dds_::S_Response_
//   graph                             ros_discovery_info   rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_
// Source: make_fqtopic in rmw_node.cpp, demangle.cpp of rmw_cyclonedds_cpp (jazzy).
// All functions are pure. Threads: any. Errors: a Problem with an empty `where`, which the caller sets.

/// DDS's limit for topic and type names. A vendor may truncate longer names, so that two names become equal.
inline constexpr std::size_t kMaxDdsNameBytes = 255;
inline constexpr std::string_view kDiscoveryTopic = "ros_discovery_info";

/// Returns the DDS name of a topic, or of one half of a service. `name` is fully qualified. With
/// `avoid_ros_conventions` it gets no prefix (but the suffix of a service), and must only be short and not empty.
[[nodiscard]] Result<std::string, Problem> dds_topic_name(std::string_view name, bool avoid_ros_conventions = false);
[[nodiscard]] Result<std::string, Problem> dds_request_name(std::string_view service,
                                                            bool avoid_ros_conventions = false);
[[nodiscard]] Result<std::string, Problem> dds_reply_name(std::string_view service, bool avoid_ros_conventions = false);

/// The role of a DDS topic in ROS 2.
enum class WireKind : std::uint8_t {
  Topic,      ///< rt/...
  Request,    ///< rq/...Request
  Reply,      ///< rr/...Reply
  Discovery,  ///< ros_discovery_info
  Foreign,    ///< Any other name, including those that ROS 2 does not allow: such endpoints have no ROS name.
};
struct RosName {
  WireKind kind = WireKind::Foreign;
  std::string name;  ///< Fully qualified name of the topic or service; empty for Discovery and Foreign.
  friend bool operator==(const RosName&, const RosName&) = default;
};
/// Reads a name from the network. The result is safe to show on a terminal, and mangles to the same name again. A name
/// that ROS 2 does not allow is Foreign; rmw lists every name with the right prefix.
[[nodiscard]] RosName ros_name(std::string_view dds_topic);

/// Converts "std_msgs/msg/String" to "std_msgs::msg::dds_::String_". For a MessageType use its dds_name.
[[nodiscard]] Result<std::string, Problem> dds_type_name(std::string_view ros_type);
/// Converts a DDS type name to ROS 2's. Returns nothing for a name that dds_type_name() does not produce.
[[nodiscard]] std::optional<std::string> ros_type_name(std::string_view dds_type);
/// Returns the service type, "pkg/srv/S", of which a ROS type is the request or the response; nothing for other types.
[[nodiscard]] std::optional<std::string> service_of_half(std::string_view ros_type);

/// Returns the ROS name of the topic of a service's introspection events.
[[nodiscard]] std::string service_event_topic(std::string_view service);

}  // namespace nacelle::transport_dds
