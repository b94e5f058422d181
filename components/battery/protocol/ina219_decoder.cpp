// SPDX-License-Identifier: Apache-2.0
#include "battery/protocol/ina219_decoder.hpp"

#include <algorithm>

namespace nacelle::battery {
namespace {

// Of the register Bus.
constexpr unsigned kOverflown = 1U << 0U, kConverted = 1U << 1U, kBusAt = 3;

bool begins_block(const std::uint8_t* block, std::size_t known) {
  const bool has_tag = std::any_of(Ina219Decoder::kOrder.begin(), Ina219Decoder::kOrder.end(),
                                   [&](Ina219Register reg) { return block[0] == static_cast<std::uint8_t>(reg); });
  return has_tag && (known < 2 || block[1] == 2) && (known < 3 || block[2] == 0);
}

}  // namespace

void Ina219Decoder::restart() {
  stats_.skipped_bytes += pending_;
  pending_ = 0;
  next_ = 0;
}

bool Ina219Decoder::take() {
  while (pending_ > 0 && !begins_block(block_.data(), pending_)) {
    std::copy(block_.begin() + 1, block_.begin() + static_cast<std::ptrdiff_t>(pending_), block_.begin());
    --pending_;
    ++stats_.skipped_bytes;
    next_ = 0;
  }
  if (pending_ < kBlockBytes) return false;
  pending_ = 0;
  ++stats_.blocks;
  const auto reg = static_cast<Ina219Register>(block_[0]);
  if (reg != kOrder[next_]) next_ = 0;
  if (reg != kOrder[next_]) return false;
  store(static_cast<std::uint16_t>(block_[3] << 8 | block_[4]));
  next_ = (next_ + 1) % kOrder.size();
  if (next_ != 0) return false;
  ++stats_.readings;
  return true;
}

void Ina219Decoder::store(std::uint16_t value) {
  switch (kOrder[next_]) {
    case Ina219Register::Config:
      reading_ = {};
      reading_.config = value;
      break;
    case Ina219Register::Shunt: reading_.shunt_counts = static_cast<std::int16_t>(value); break;
    case Ina219Register::Bus:
      reading_.bus_counts = static_cast<std::uint16_t>(value >> kBusAt);
      reading_.is_converted = (value & kConverted) != 0;
      reading_.has_overflown = (value & kOverflown) != 0;
      break;
    case Ina219Register::Current: reading_.current_counts = static_cast<std::int16_t>(value); break;
    default: break;
  }
}

}  // namespace nacelle::battery
