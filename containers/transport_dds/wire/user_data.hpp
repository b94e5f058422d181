// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "nacelle/base/bytes.hpp"
#include "transport_dds/wire/gid.hpp"

namespace nacelle::transport_dds {

// What ROS 2 tells in the USER_DATA of participants and endpoints: `key=value;key=value;`, ASCII, no NUL at the end.
//
//   participant                enclave=/;
//   topic's writer, reader     typehash=RIHS01_<64 hex>;
//   client's writer, reader    clientid= 1.10.7f.63.0.0.0.8;typehash=...;     (16 numbers)
//   server's writer, reader    serviceid= 1.10.fa.5e.0.0.0.5;typehash=...;    (16 numbers)
// Source: key_value.hpp of rmw, qos.cpp of rmw_dds_common, rmw_node.cpp of rmw_cyclonedds_cpp (jazzy).

using UserData = std::map<std::string, std::string, std::less<>>;

/// Reads hostile bytes exactly as ROS 2 does, so that both sides agree on who is a ROS participant.
///
/// Keys are letters and digits, values one byte or more. A value ends at a ';' that something else follows, so ";;"
/// stands for a ';' only at the end of everything; one byte between two pairs is passed over; the last of equal keys
/// counts; NULs behind the last pair are padding. Anything else makes the whole map empty: a peer that uses USER_DATA
/// for something of its own.
[[nodiscard]] UserData parse_user_data(ByteView bytes);

/// Longer user data is not read at all: what ROS 2 writes has at most some 400 bytes.
inline constexpr std::size_t kMostUserDataBytes = 4096;
/// Longer values are taken as not given.
inline constexpr std::size_t kMostEnclaveBytes = 255, kMostIdTextBytes = 64;

/// The enclave of a ROS 2 participant; nothing for a foreign one, whose nodes are not listed.
[[nodiscard]] std::optional<std::string> read_participant_user_data(ByteView bytes);

/// What an endpoint's user data says; empty texts are not given.
struct EndpointUserData {
  std::string type_hash;   ///< "RIHS01_" and 64 lower-case hexadecimal digits, else empty.
  std::string client_id;   ///< Of both endpoints of a client, and of them only. Compared as text, never read.
  std::string service_id;  ///< The same of a server.
  friend bool operator==(const EndpointUserData&, const EndpointUserData&) = default;
};
[[nodiscard]] EndpointUserData read_endpoint_user_data(ByteView bytes);

/// The bytes to announce. Preconditions: no text holds a ';'.
[[nodiscard]] std::string write_participant_user_data(std::string_view enclave = "/");
[[nodiscard]] std::string write_endpoint_user_data(const EndpointUserData& data);

/// True for a hash that ROS 2 reads: version 1, digits of either case, nothing behind them.
[[nodiscard]] bool is_type_hash(std::string_view text);

/// The id of a participant's client or server number `count` (from 1; clients and servers share the numbers), as it is
/// written: prefix and big-endian count in hexadecimal without leading zeros, joined by '.', the first number padded to
/// two with a blank.
[[nodiscard]] std::string endpoint_id_text(const Gid& participant, std::uint32_t count);

}  // namespace nacelle::transport_dds
