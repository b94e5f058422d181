// SPDX-License-Identifier: Apache-2.0
#include "control/wire.hpp"

#include <bit>
#include <cmath>

namespace nacelle::control {
namespace {

void append_u64(std::string& out, std::uint64_t value) {
  for (unsigned i = 0; i < 8; ++i) out.push_back(static_cast<char>(value >> (8 * i)));
}

std::uint64_t load_u64(const std::uint8_t* at) {
  std::uint64_t value = 0;
  for (unsigned i = 0; i < 8; ++i) value |= static_cast<std::uint64_t>(at[i]) << (8 * i);
  return value;
}

}  // namespace

std::optional<NamePair> read_name_pair(ByteView payload) {
  const std::string_view text = as_text(payload);
  const std::size_t zero = text.find('\0');
  if (zero == std::string_view::npos || zero == 0 || zero + 1 == text.size()) return std::nullopt;
  const NamePair names{text.substr(0, zero), text.substr(zero + 1)};
  if (names.second.find('\0') != std::string_view::npos) return std::nullopt;
  return names;
}

void append_name_pair(std::string& out, NamePair names) {
  out.append(names.first).push_back('\0');
  out.append(names.second);
}

std::optional<Publication> read_publication(ByteView payload) {
  if (payload.size() < 2) return std::nullopt;
  return Publication{load_le16(payload.data()), payload.subspan(2)};
}

void append_handle(std::string& out, std::uint16_t handle) {
  out.push_back(static_cast<char>(handle));
  out.push_back(static_cast<char>(handle >> 8));
}

std::optional<std::uint16_t> read_handle(ByteView payload) {
  if (payload.size() != 2) return std::nullopt;
  return load_le16(payload.data());
}

void append_transform(std::string& out, const TransformAnswer& answer) {
  out.push_back(answer.known ? '\1' : '\0');
  append_u64(out, static_cast<std::uint64_t>(answer.stamp.nanoseconds()));
  for (const double value : answer.translation_m) append_u64(out, std::bit_cast<std::uint64_t>(value));
  for (const double value : answer.rotation_xyzw) append_u64(out, std::bit_cast<std::uint64_t>(value));
}

std::optional<TransformAnswer> read_transform(ByteView payload) {
  if (payload.size() != kTransformBytes) return std::nullopt;
  TransformAnswer answer;
  answer.known = payload[0] == 1;
  const std::uint8_t* at = payload.data() + 1;
  answer.stamp.since_origin = Duration{static_cast<std::int64_t>(load_u64(at))};
  for (double& value : answer.translation_m) value = std::bit_cast<double>(load_u64(at += 8));
  for (double& value : answer.rotation_xyzw) value = std::bit_cast<double>(load_u64(at += 8));
  for (const double value : answer.translation_m) {
    if (!std::isfinite(value)) return std::nullopt;
  }
  return answer;
}

}  // namespace nacelle::control
