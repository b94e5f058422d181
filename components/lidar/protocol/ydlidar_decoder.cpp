// SPDX-License-Identifier: Apache-2.0
#include "lidar/protocol/ydlidar_decoder.hpp"

#include <cmath>
#include <numbers>

namespace nacelle::lidar {

using namespace ydlidar_layout;

bool YdlidarDecoder::checksum_is_right(std::size_t length) const {
  unsigned sum = 0;
  for (std::size_t at = 0; at < kHeadBytes; at += 2) sum ^= load_le16(window_.data() + at);  // with the checksum itself
  for (std::size_t at = kHeadBytes; at < length; at += sample_bytes_) {
    if (sample_bytes_ == 3) sum ^= window_[at];
    sum ^= load_le16(window_.data() + at + sample_bytes_ - 2);
  }
  return sum == 0;
}

std::size_t YdlidarDecoder::settle() {
  for (;;) {
    std::size_t start = 0;
    while (start < pending_ && (window_[start] != kFirst || (start + 1 < pending_ && window_[start + 1] != kSecond)))
      ++start;
    if (start > 0) skip(start);
    if (pending_ < wanted()) return 0;
    const std::size_t length = kHeadBytes + window_[3] * sample_bytes_;
    // Fields are checked as soon as they are there: a false start shall not swallow the packets after it.
    const unsigned first = load_le16(window_.data() + 4), last = load_le16(window_.data() + 6);
    const bool fits = window_[3] > 0 && (first & 1U) == 1 && (last & 1U) == 1;
    if (!fits || !checksum_is_right(length)) {
      ++stats_.bad_checksums;
      skip(1);
      continue;
    }
    stats_.framed_bytes += length;
    if (first >> 1U < kFullTurn_q6 && last >> 1U < kFullTurn_q6) {
      ++stats_.frames;
      return length;
    }
    ++stats_.implausible;
    remove(length);
  }
}

YdlidarPacket YdlidarDecoder::read(std::size_t length) {
  return {.samples = ByteView{window_.data() + kHeadBytes, length - kHeadBytes},
          .count = window_[3],
          .first_deg = (load_le16(window_.data() + 4) >> 1U) / 64.0,
          .last_deg = (load_le16(window_.data() + 6) >> 1U) / 64.0,
          .starts_turn = (window_[2] & 1U) != 0,
          .turns_per_second = (window_[2] >> 1U) / 10.0,
          .skipped_bytes = stats_.skipped_bytes - std::exchange(skipped_before_, stats_.skipped_bytes),
          .bytes = length};
}

double ydlidar_correction_deg(double range_mm) {
  if (range_mm <= 0.0) return 0.0;
  return std::atan(21.8 * (155.3 - range_mm) / (155.3 * range_mm)) * 180.0 / std::numbers::pi;
}

}  // namespace nacelle::lidar
