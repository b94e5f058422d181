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

// A request or a reply as rmw_cyclonedds writes it. The header takes 16 bytes, so what follows is aligned as if it were
// not there.
//
//   offset  bytes  field           becomes
//        0      2  representation  00 01 little-endian (written), 00 00 big-endian (read too): of the header as well
//        2      2  options         00 00 when written, ignored when read
//        4      8  client          a random number of the request's writer, returned in the reply
//       12      8  sequence        of the request, from 1; returned in the reply
//       20      n  body            the request's or the response's members
// Source: serdata.hpp, Serialization.cpp, rmw_node.cpp of rmw_cyclonedds_cpp (jazzy). Fast DDS writes no header:
// another protocol.

inline constexpr std::size_t kCallHeaderBytes = 16;

/// Which call a request or reply belongs to.
struct CallHeader {
  std::uint64_t client = 0;
  std::int64_t sequence = 0;
  friend bool operator==(const CallHeader&, const CallHeader&) = default;
};

/// The exact number of bytes that write_call() writes. Allocates: nothing.
[[nodiscard]] std::size_t call_size(const msgs::MessageType& type, const void* message);
/// Writes call_size() bytes, encapsulation included. Allocates: nothing.
void write_call(const CallHeader& header, const msgs::MessageType& type, const void* message, std::uint8_t* out);

/// A request or reply from the network.
struct Call {
  CallHeader header;
  ByteView message;  ///< The body behind an encapsulation of its own, as msgs::decode() reads it.
};
/// Splits hostile bytes; the body is left to decode(). `scratch` takes the body and must live as long as
/// `Call::message` is used.
/// Errors: Truncated below 20 bytes; UnknownEncoding. Allocates: in `scratch`, as much as the payload has bytes.
[[nodiscard]] Result<Call, msgs::DecodeFault> read_call(ByteView payload, Bytes& scratch);
/// The same without a copy, for a caller that is the only owner of the bytes: the encapsulation is moved down to the
/// body, over the header's end.
[[nodiscard]] Result<Call, msgs::DecodeFault> read_call_in_place(ByteSpan payload);

/// The QoS of all four ends of a service: reliable, volatile, and of its type the depth that ROS 2's own nodes have.
/// `service_type`: "rcl_interfaces/srv/GetParameters". Source: recorded (ddsdump_*.jsonl): rmw_qos_profile_parameters,
/// component_manager.cpp, rmw_qos_profile_services_default.
[[nodiscard]] DdsQos service_qos(std::string_view service_type);

/// Whether an end of a service with this user data is of a ROS 2 middleware that is not rmw_cyclonedds: those give the
/// type's hash and no id. Their requests and replies have no header (rmw_fastrtps has the number in RTPS's inline QoS,
/// which Cyclone does not expose): neither side understands the other. An endpoint that announces neither is not a ROS
/// 2 middleware, and is assumed to be compatible. Source: rmw_request.cpp, rmw_client.cpp of rmw_fastrtps (jazzy).
[[nodiscard]] inline bool has_other_protocol(const EndpointUserData& data) {
  return !data.type_hash.empty() && data.client_id.empty() && data.service_id.empty();
}

/// A client sees the replies to all clients of its service; its own is the one that returns its number.
[[nodiscard]] inline bool is_reply_to(const CallHeader& reply, std::uint64_t own_client) {
  return reply.client == own_client;
}

/// What a server does with a finished reply.
enum class ReplyStep : std::uint8_t {
  Send,
  Wait,    ///< The client's reply reader is not matched yet: look again after kReplyPoll, or when a reader matches.
  Drop,    ///< The client is gone.
  GiveUp,  ///< The reader has not come within kReplyPatience: the client, if it still waits, gets no reply.
};
inline constexpr Duration kReplyPatience = 100ms, kReplyPoll = 10ms;

/// A client's two endpoints are discovered one after the other: a reply that is sent between them would be lost.
///
/// `request_writer`: the client_id that the matched request writer announces, empty where it announces none (Fast DDS,
/// others); null when it is matched no more. `reply_readers`: the client_ids of all matched reply readers. `waited`:
/// since the first look.
/// Source: rmw_send_response, check_for_response_reader.
[[nodiscard]] ReplyStep reply_step(const std::string* request_writer, std::span<const std::string> reply_readers,
                                   Duration waited);

/// Whether a client may send: some server has both its ends matched. Texts are the service_ids of all matched request
/// readers and reply writers, empty where one announces none. Source: check_for_service_reader_writer.
[[nodiscard]] bool is_service_available(std::span<const std::string> request_readers,
                                        std::span<const std::string> reply_writers);

}  // namespace nacelle::transport_dds
