// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::transport_dds {

// How ROS 2 names DDS's topics and types. An action is three services and two topics, a service event a topic: no names
// of their own.
//
//   ROS 2                             DDS topic            DDS type
//   topic /a/b of pkg/msg/T           rt/a/b               pkg::msg::dds_::T_
//   request to /n/s of pkg/srv/S      rq/n/sRequest        pkg::srv::dds_::S_Request_
//   reply of /n/s                     rr/n/sReply          pkg::srv::dds_::S_Response_
//   graph                             ros_discovery_info   rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_
// Source: make_fqtopic in rmw_node.cpp, demangle.cpp of rmw_cyclonedds_cpp (jazzy).
// Everything here is pure. Threads: any. Errors: a Problem whose `where` is empty; the caller knows it.

/// DDS's own limit for topic and type names; a vendor may cut longer ones, and two names become one.
inline constexpr std::size_t kMaxDdsNameBytes = 255;
inline constexpr std::string_view kDiscoveryTopic = "ros_discovery_info";

/// `name` is fully qualified. With avoid_ros_namespace_conventions the name stays as it is, and only has to be short
/// enough.
[[nodiscard]] Result<std::string, Problem> dds_topic_name(std::string_view name, bool avoid_ros_conventions = false);
[[nodiscard]] Result<std::string, Problem> dds_request_name(std::string_view service,
                                                            bool avoid_ros_conventions = false);
[[nodiscard]] Result<std::string, Problem> dds_reply_name(std::string_view service, bool avoid_ros_conventions = false);

/// What a DDS topic is to ROS 2.
enum class WireKind : std::uint8_t {
  Topic,      ///< rt/...
  Request,    ///< rq/...Request
  Reply,      ///< rr/...Reply
  Discovery,  ///< ros_discovery_info
  Foreign,    ///< Anything else, a name that ROS 2 does not allow included: such endpoints have no ROS name.
};
struct RosName {
  WireKind kind = WireKind::Foreign;
  std::string name;  ///< Fully qualified name of the topic or service; empty for Discovery and Foreign.
  friend bool operator==(const RosName&, const RosName&) = default;
};
/// Reads a name from the network. What it returns may be shown on a terminal, and mangles to the same name again.
/// Unlike rmw, which lists any name with the right prefix, names that ROS 2 does not allow are Foreign.
[[nodiscard]] RosName ros_name(std::string_view dds_topic);

/// "std_msgs/msg/String" becomes "std_msgs::msg::dds_::String_". A MessageType knows its dds_name already.
[[nodiscard]] Result<std::string, Problem> dds_type_name(std::string_view ros_type);
/// The way back: nothing where the name is not one that ROS 2 would give to a type.
[[nodiscard]] std::optional<std::string> ros_type_name(std::string_view dds_type);
/// The type of the service that a ROS type is the request or the response of: "pkg/srv/S". Nothing for every other
/// type.
[[nodiscard]] std::optional<std::string> service_of_half(std::string_view ros_type);

/// Where a service publishes what its clients and it do: the ROS name of the topic.
[[nodiscard]] std::string service_event_topic(std::string_view service);

}  // namespace nacelle::transport_dds
