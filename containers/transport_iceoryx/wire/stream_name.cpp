// SPDX-License-Identifier: Apache-2.0
#include "transport_iceoryx/wire/stream_name.hpp"

#include <fmt/format.h>

#include <cstdint>

namespace nacelle::transport_iceoryx {
namespace {

// FNV-1a. Both ends are of one host and one release, and deliberate collisions are no concern: a program that can write
// here can write to the stream itself.
std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : text) hash = (hash ^ static_cast<std::uint8_t>(c)) * 1099511628211ULL;
  return hash;
}

}  // namespace

std::string short_name(std::string_view name) {
  if (name.size() <= kMostNameBytes) return std::string(name);
  const std::string hash = fmt::format("{:016x}~", hash_of(name));
  return hash + std::string(name.substr(name.size() - (kMostNameBytes - hash.size())));
}

}  // namespace nacelle::transport_iceoryx
