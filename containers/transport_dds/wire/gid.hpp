// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "nacelle/base/bytes.hpp"

namespace nacelle::transport_dds {

/// The identifier of a participant, writer or reader: a DDS GUID, in wire order.
///
///   offset  bytes  field
///        0     12  prefix     of the participant
///       12      3  key        of the entity
///       15      1  kind       03 writer, 04 reader (without a key: all of ROS 2's), 02 and 07 with one, c1 participant
/// Source: OMG DDSI-RTPS 2.3 section 9.3.1; 16 bytes in ROS 2 since iron (humble has 24).
struct Gid {
  static constexpr std::size_t kBytes = 16, kPrefixBytes = 12;
  std::array<std::uint8_t, kBytes> bytes{};

  /// Returns the participant of this endpoint: the same prefix, entity 00 00 01 c1.
  [[nodiscard]] Gid participant() const;
  [[nodiscard]] bool is_participant() const { return *this == participant(); }
  [[nodiscard]] bool same_participant(const Gid& other) const {
    return std::equal(bytes.begin(), bytes.begin() + kPrefixBytes, other.bytes.begin());
  }
  /// Returns 32 lower-case hexadecimal digits.
  [[nodiscard]] std::string text() const { return to_hex(bytes); }

  friend auto operator<=>(const Gid&, const Gid&) = default;
};

}  // namespace nacelle::transport_dds

template <>
struct std::hash<nacelle::transport_dds::Gid> {
  std::size_t operator()(const nacelle::transport_dds::Gid& gid) const noexcept;
};
