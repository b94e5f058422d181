// SPDX-License-Identifier: Apache-2.0
#include "imu/protocol/wt901_decoder.hpp"

#include <cmath>
#include <numeric>

namespace nacelle::imu {

using namespace wt901_layout;

std::optional<Wt901Command> rate_command(double rate_hz) {
  for (std::size_t i = 0; i < kWt901RatesHz.size(); ++i) {
    if (std::abs(kWt901RatesHz[i] - rate_hz) < 1e-6) {
      return Wt901Command{0xFF, 0xAA, 0x03, static_cast<std::uint8_t>(i + 1), 0x00};
    }
  }
  return std::nullopt;
}

void Wt901Decoder::skip(std::size_t count) {
  stats_.skipped_bytes += count;
  pending_ -= count;
  std::memmove(window_.data(), window_.data() + count, pending_);
}

bool Wt901Decoder::settle(Wt901Frame& frame) {
  for (;;) {
    // Skip to the next byte that may start a frame, judging by the bytes so far.
    std::size_t start = 0;
    while (start < pending_ &&
           (window_[start] != kStartByte || (start + 1 < pending_ && (window_[start + 1] & 0xF0U) != 0x50U))) {
      ++start;
    }
    if (start > 0) skip(start);
    if (pending_ < kFrameBytes) return false;
    const auto sum = std::accumulate(window_.begin(), window_.begin() + kChecksum, 0U);
    if (static_cast<std::uint8_t>(sum) != window_[kChecksum]) {
      // The real frame may begin inside this one: drop one byte only.
      ++stats_.bad_checksums;
      skip(1);
      continue;
    }
    frame.type = window_[kType];
    for (std::size_t i = 0; i < frame.values.size(); ++i) {
      frame.values[i] = load_le16s(window_.data() + kValues + 2 * i);
    }
    ++stats_.frames;
    pending_ = 0;
    return true;
  }
}

}  // namespace nacelle::imu
