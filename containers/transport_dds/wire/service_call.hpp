// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "transport_dds/wire/dds_qos.hpp"
#include "transport_dds/wire/user_data.hpp"

namespace nacelle::transport_dds {

// The layout of a request or a reply of rmw_cyclonedds. The header takes 16 bytes, so the body is aligned as it is
// without a header.
//
//   offset  bytes  field           becomes
//        0      2  representation  00 01 little-endian (written), 00 00 big-endian (read too); of header and body
//        2      2  options         00 00 when written, ignored when read
//        4      8  client          a random number of the request's writer, returned in the reply
//       12      8  sequence        of the request, from 1; returned in the reply
//       20      n  body            the request's or the response's members
// Source: serdata.hpp, Serialization.cpp, rmw_node.cpp of rmw_cyclonedds_cpp (jazzy). Fast DDS uses another protocol,
// without this header.

inline constexpr std::size_t kCallHeaderBytes = 16;

/// Identifies the call of a request or reply.
struct CallHeader {
  std::uint64_t client = 0;
  std::int64_t sequence = 0;
  friend bool operator==(const CallHeader&, const CallHeader&) = default;
};

/// Returns the exact number of bytes that write_call() writes. Allocates: nothing.
[[nodiscard]] std::size_t call_size(const msgs::MessageType& type, const void* message);
/// Writes call_size() bytes, encapsulation included. Allocates: nothing.
void write_call(const CallHeader& header, const msgs::MessageType& type, const void* message, std::uint8_t* out);

/// A request or reply from the network.
struct Call {
  CallHeader header;
  ByteView message;  ///< The body with an encapsulation, as msgs::decode() reads it.
};
/// Splits hostile bytes into header and body; does not check the body. The body is copied to `scratch`, which must live
/// as long as `Call::message` is used.
/// Errors: Truncated below 20 bytes; UnknownEncoding. Allocates: in `scratch`, up to the size of the payload.
[[nodiscard]] Result<Call, msgs::DecodeFault> read_call(ByteView payload, Bytes& scratch);
/// The same without a copy, for a caller that is the only owner of the bytes: copies the encapsulation to the place
/// before the body, over the end of the header.
[[nodiscard]] Result<Call, msgs::DecodeFault> read_call_in_place(ByteSpan payload);

/// Returns the QoS of all four endpoints of a service: reliable, volatile, with the depth that ROS 2's own nodes use
/// for a service of this type. `service_type`: "rcl_interfaces/srv/GetParameters".
/// Source: recorded (ddsdump_*.jsonl); rmw_qos_profile_parameters, component_manager.cpp,
/// rmw_qos_profile_services_default.
[[nodiscard]] DdsQos service_qos(std::string_view service_type);

/// Returns whether a service's endpoint with this user data belongs to another ROS 2 middleware than rmw_cyclonedds:
/// such endpoints announce the type's hash and no id. Their requests and replies have no header (rmw_fastrtps uses
/// RTPS's inline QoS, which Cyclone does not expose), so calls between the two fail. An endpoint that announces neither
/// does not belong to a ROS 2 middleware, and is assumed to be compatible.
/// Source: rmw_request.cpp, rmw_client.cpp of rmw_fastrtps (jazzy).
[[nodiscard]] inline bool has_other_protocol(const EndpointUserData& data) {
  return !data.type_hash.empty() && data.client_id.empty() && data.service_id.empty();
}

/// Returns whether a reply is for this client: a client receives the replies to all clients of its service.
[[nodiscard]] inline bool is_reply_to(const CallHeader& reply, std::uint64_t own_client) {
  return reply.client == own_client;
}

/// What a server must do with a reply.
enum class ReplyStep : std::uint8_t {
  Send,
  Wait,    ///< The client's reply reader is not matched yet: check again when a reader matches, or time is up.
  Drop,    ///< The client is gone.
  GiveUp,  ///< The reader has not matched within kReplyPatience: drop the reply.
};
inline constexpr Duration kReplyPatience = 100ms;

/// Decides whether a reply can be sent. A client's two endpoints are discovered one after the other, and a reply that
/// is sent before the second is matched would be lost.
///
/// `request_writer`: the client_id that the matched request writer announces, empty if it announces none (Fast DDS,
/// others); null if it is no longer matched. `reply_readers`: the client_ids of all matched reply readers. `waited`:
/// the time since the reply was ready.
/// Source: rmw_send_response, check_for_response_reader.
[[nodiscard]] ReplyStep reply_step(const std::string* request_writer, std::span<const std::string> reply_readers,
                                   Duration waited);

/// Returns whether a client may send: both endpoints of a server are matched. The arguments are the service_ids of all
/// matched request readers and reply writers; an endpoint that announces none has an empty one.
/// Source: check_for_service_reader_writer.
[[nodiscard]] bool is_service_available(std::span<const std::string> request_readers,
                                        std::span<const std::string> reply_writers);

}  // namespace nacelle::transport_dds
