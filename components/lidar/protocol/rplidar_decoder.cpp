// SPDX-License-Identifier: Apache-2.0
#include "lidar/protocol/rplidar_decoder.hpp"

namespace nacelle::lidar {
namespace {

using namespace rplidar_layout;

/// Node angles are corrected by range, so that one may lie a little behind the one before.
constexpr int kMostBack_q6 = 12 * 64, kMostAhead_q6 = 30 * 64;

bool continues(unsigned before_q6, unsigned angle_q6) {
  int ahead = static_cast<int>(angle_q6) - static_cast<int>(before_q6);
  if (ahead < -static_cast<int>(kTurn_q6) / 2) ahead += static_cast<int>(kTurn_q6);
  if (ahead > static_cast<int>(kTurn_q6) / 2) ahead -= static_cast<int>(kTurn_q6);
  return ahead >= -kMostBack_q6 && ahead <= kMostAhead_q6;
}

}  // namespace

void RplidarDecoder::expect(RplidarAnswer type) {
  stats_.skipped_bytes += pending_;
  pending_ = 0;
  expected_ = type;
  length_ = 0;
  believes_ = false;
  is_first_ = true;
}

std::size_t RplidarDecoder::wanted() const {
  if (expected_ == RplidarAnswer::None) return 1;
  if (length_ == 0) return kDescriptorBytes;
  if (expected_ == RplidarAnswer::Nodes && !believes_) return kNodesToBelieve * kNodeBytes;
  return length_;
}

void RplidarDecoder::skip(std::size_t count) {
  stats_.skipped_bytes += count;
  remove(count);
}

void RplidarDecoder::remove(std::size_t count) {
  pending_ -= count;
  std::memmove(window_.data(), window_.data() + count, pending_);
}

std::size_t RplidarDecoder::settle() {
  if (expected_ == RplidarAnswer::None) {
    if (pending_ > 0) skip(pending_);
    return 0;
  }
  if (length_ == 0 && settle_descriptor() == 0) return 0;
  if (!is_stream(expected_)) {
    if (pending_ < length_) return 0;
    stats_.framed_bytes += length_;
    return std::exchange(length_, 0);
  }
  return expected_ == RplidarAnswer::Nodes ? settle_node() : settle_capsule();
}

/// Returns the length of the answer's packets once its descriptor is at the window's front, which it then leaves.
std::size_t RplidarDecoder::settle_descriptor() {
  for (;;) {
    std::size_t start = 0;
    while (start < pending_ && (window_[start] != kRequest || (start + 1 < pending_ && window_[start + 1] != kAnswer)))
      ++start;
    if (start > 0) skip(start);
    if (pending_ < kDescriptorBytes) return 0;
    const std::size_t length = load_le16(window_.data() + 2);
    const unsigned mode = is_stream(expected_) ? 0x40 : 0x00;
    const std::size_t fixed = packet_bytes_of(expected_);
    const bool fits = fixed != 0 ? length == fixed : length >= 4 && length <= kMostConfigurationBytes;
    if (fits && window_[4] == 0 && window_[5] == mode && window_[6] == static_cast<std::uint8_t>(expected_)) {
      stats_.framed_bytes += kDescriptorBytes;
      remove(kDescriptorBytes);
      length_ = length;
      return length;
    }
    skip(1);
  }
}

bool RplidarDecoder::nodes_follow() const {
  for (std::size_t i = 0; i < kNodesToBelieve; ++i) {
    const std::uint8_t* const node = window_.data() + i * kNodeBytes;
    if (!is_rplidar_node(node)) return false;
    if (i > 0 && !continues(node_angle_q6(node - kNodeBytes), node_angle_q6(node))) return false;
  }
  return true;
}

std::size_t RplidarDecoder::settle_node() {
  for (;;) {
    if (pending_ < wanted()) return 0;
    const unsigned angle_q6 = node_angle_q6(window_.data());
    if (believes_ && (!is_rplidar_node(window_.data()) || !continues(last_angle_q6_, angle_q6))) {
      ++stats_.bad_checksums;
      believes_ = false;
      skip(1);
      continue;
    }
    if (!believes_) {
      if (!nodes_follow()) {
        skip(1);
        continue;
      }
      believes_ = true;
    }
    last_angle_q6_ = angle_q6;
    ++stats_.frames;
    stats_.framed_bytes += kNodeBytes;
    return kNodeBytes;
  }
}

std::size_t RplidarDecoder::settle_capsule() {
  for (;;) {
    std::size_t start = 0;
    while (start < pending_ &&
           ((window_[start] & 0xF0U) != 0xA0U || (start + 1 < pending_ && (window_[start + 1] & 0xF0U) != 0x50U)))
      ++start;
    if (start > 0) skip(start);
    if (pending_ < length_) return 0;
    const ByteView packet{window_.data(), length_};
    if (!is_rplidar_capsule(packet)) {
      ++stats_.bad_checksums;
      skip(1);
      continue;
    }
    stats_.framed_bytes += length_;
    if (capsule_angle_q6(packet) < kTurn_q6) {
      ++stats_.frames;
      return length_;
    }
    ++stats_.implausible;
    is_first_ = true;
    remove(length_);
  }
}

}  // namespace nacelle::lidar
