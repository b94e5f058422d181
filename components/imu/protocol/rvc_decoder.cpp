// SPDX-License-Identifier: Apache-2.0
#include "imu/protocol/rvc_decoder.hpp"

#include <numeric>

namespace nacelle::imu {

void RvcDecoder::skip(std::size_t count) {
  stats_.skipped_bytes += count;
  pending_ -= count;
  std::memmove(window_.data(), window_.data() + count, pending_);
}

bool RvcDecoder::settle(RvcFrame& frame) {
  using namespace rvc_layout;
  for (;;) {
    std::size_t start = 0;
    while (start < pending_ &&
           (window_[start] != kStartByte || (start + 1 < pending_ && window_[start + 1] != kStartByte))) {
      ++start;
    }
    if (start > 0) skip(start);
    if (pending_ < kFrameBytes) return false;
    const auto sum = std::accumulate(window_.begin() + kIndex, window_.begin() + kChecksum, 0U);
    if (static_cast<std::uint8_t>(sum) != window_[kChecksum]) {
      // The real frame may begin inside this one: drop one byte only.
      ++stats_.bad_checksums;
      skip(1);
      continue;
    }
    frame.index = window_[kIndex];
    for (std::size_t i = 0; i < 3; ++i) {
      frame.angles_cdeg[i] = load_le16s(window_.data() + kAngles + 2 * i);
      frame.acceleration_mg[i] = load_le16s(window_.data() + kAcceleration + 2 * i);
    }
    ++stats_.frames;
    pending_ = 0;
    return true;
  }
}

}  // namespace nacelle::imu
