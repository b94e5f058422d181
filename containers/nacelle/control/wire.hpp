// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::control {

/// Two names in one payload, as "first 0 second".
struct NamePair {
  std::string_view first, second;
};
/// Returns nothing unless there is exactly one zero byte and both names are non-empty.
[[nodiscard]] std::optional<NamePair> read_name_pair(ByteView payload);
void append_name_pair(std::string& out, NamePair names);

/// The payload of a Publish frame.
struct Publication {
  std::uint16_t handle = 0;
  ByteView cdr;
};
[[nodiscard]] std::optional<Publication> read_publication(ByteView payload);
void append_handle(std::string& out, std::uint16_t handle);
[[nodiscard]] std::optional<std::uint16_t> read_handle(ByteView payload);

/// The payload of a Transform frame: X_TS, source frame in target frame, at `stamp`.
///
///   offset  bytes  field
///        0      1  1: known; 0: unknown, the rest is then the identity at stamp 0
///        1      8  stamp, ns since the epoch, int64 little-endian
///        9     24  translation x, y, z in m, float64
///       33     32  rotation x, y, z, w
struct TransformAnswer {
  bool known = false;
  WallTime stamp{};
  std::array<double, 3> translation_m{};
  std::array<double, 4> rotation_xyzw{0, 0, 0, 1};
};
inline constexpr std::size_t kTransformBytes = 65;
void append_transform(std::string& out, const TransformAnswer& answer);
[[nodiscard]] std::optional<TransformAnswer> read_transform(ByteView payload);

}  // namespace nacelle::control
