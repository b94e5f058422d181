// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/can_wire.hpp"

#include <bit>

namespace nacelle::simulation {
namespace {

static_assert(std::endian::native == std::endian::little, "the identifier is in the machine's byte order");

constexpr std::size_t kSize = 16;

}  // namespace

void append(Bytes& bytes, const CanMessage& message) {
  const std::uint32_t word = message.id + (message.is_long ? 1U << 31 : 0) + (message.is_remote ? 1U << 30 : 0);
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::uint8_t>(word >> shift));
  bytes.push_back(static_cast<std::uint8_t>(message.data.size()));
  bytes.insert(bytes.end(), 3, 0);
  for (std::size_t i = 0; i < 8; ++i) bytes.push_back(i < message.data.size() ? message.data[i] : std::uint8_t{0});
}

std::vector<CanMessage> CanWire::cut(ByteView bytes) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  std::vector<CanMessage> messages;
  std::size_t at = 0;
  for (; buffer_.size() - at >= kSize; at += kSize) {
    const std::uint8_t* const raw = buffer_.data() + at;
    const std::uint32_t word = raw[0] + 0x100U * raw[1] + 0x10000U * raw[2] + 0x1000000U * raw[3];
    if (raw[4] > 8 || (word >> 29 & 1U) != 0) {
      ++bad_frames_;
      continue;
    }
    CanMessage message;
    message.id = word & 0x1FFFFFFFU;
    message.is_long = word >> 31 != 0;
    message.is_remote = (word >> 30 & 1U) != 0;
    if (!message.is_remote) message.data.assign(raw + 8, raw + 8 + raw[4]);
    messages.push_back(std::move(message));
  }
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at));
  return messages;
}

}  // namespace nacelle::simulation
