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

// ROS 2's USER_DATA of participants and endpoints: `key=value;key=value;`, ASCII, without a NUL at the end.
//
//   participant                enclave=/;
//   topic's writer, reader     typehash=RIHS01_<64 hex>;
//   client's writer, reader    clientid= 1.10.7f.63.0.0.0.8;typehash=...;     (16 numbers)
//   server's writer, reader    serviceid= 1.10.fa.5e.0.0.0.5;typehash=...;    (16 numbers)
// Source: key_value.hpp of rmw, qos.cpp of rmw_dds_common, rmw_node.cpp of rmw_cyclonedds_cpp (jazzy).

using UserData = std::map<std::string, std::string, std::less<>>;

/// Parses hostile bytes exactly as ROS 2 does, so that both sides agree on which participants are ROS 2's.
///
/// Keys are letters and digits; values have at least one byte. A value ends before the last ';' of a row, so "a=b;;"
/// has the value "b;", and a ';' inside a value is impossible. One byte between two pairs is ignored. Of equal keys the
/// last one counts. NULs after the last pair are padding. All other bytes make the whole map empty: the peer uses
/// USER_DATA for another purpose.
[[nodiscard]] UserData parse_user_data(ByteView bytes);

/// Longer user data is ignored. ROS 2's has about 400 bytes at most.
inline constexpr std::size_t kMostUserDataBytes = 4096;
/// Longer values are ignored.
inline constexpr std::size_t kMostEnclaveBytes = 255, kMostIdTextBytes = 64;

/// Returns the enclave of a ROS 2 participant; nothing for any other participant, whose nodes are not listed.
[[nodiscard]] std::optional<std::string> read_participant_user_data(ByteView bytes);

/// The user data of an endpoint. A field that is not announced is empty.
struct EndpointUserData {
  std::string type_hash;   ///< "RIHS01_" and 64 lower-case hexadecimal digits, else empty.
  std::string client_id;   ///< Set for both endpoints of a client only. Compared as text, not parsed.
  std::string service_id;  ///< Set for both endpoints of a server only.
  friend bool operator==(const EndpointUserData&, const EndpointUserData&) = default;
};
[[nodiscard]] EndpointUserData read_endpoint_user_data(ByteView bytes);

/// Returns the bytes to announce. Preconditions: no text contains a ';'.
[[nodiscard]] std::string write_participant_user_data(std::string_view enclave = "/");
[[nodiscard]] std::string write_endpoint_user_data(const EndpointUserData& data);

/// Returns true for a hash that ROS 2 accepts: version 1 and 64 hexadecimal digits of either case.
[[nodiscard]] bool is_type_hash(std::string_view text);

/// Returns the id of a participant's client or server number `count` (from 1; clients and servers share the numbers),
/// in the format of the table above: the bytes of the prefix and of the big-endian count in hexadecimal without leading
/// zeros, joined by '.'. The first one is padded to two characters with a blank.
[[nodiscard]] std::string endpoint_id_text(const Gid& participant, std::uint32_t count);

}  // namespace nacelle::transport_dds
