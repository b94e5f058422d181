// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/port/h_bridges.hpp"

#include <cmath>
#include <utility>

namespace nacelle::diff_drive {
namespace {

constexpr std::uint64_t kForward = 0b01, kBackward = 0b10, kBoth = 0b11;

std::uint64_t levels_of(double share) {
  if (share == 0.0) return 0;
  return share > 0.0 ? kForward : kBackward;
}

}  // namespace

HBridges::HBridges(std::unique_ptr<PwmChannel> left, std::unique_ptr<PwmChannel> right,
                   std::unique_ptr<io::GpioOutputs> lines)
    : channels_{std::move(left), std::move(right)},
      lines_(std::move(lines)),
      descriptors_{channels_[0]->descriptor(), channels_[1]->descriptor()} {}

HBridges::~HBridges() { stop(); }

bool HBridges::set(double left, double right) {
  const std::array<double, 2> shares{left, right};
  const std::uint64_t levels = levels_of(left) | (levels_of(right) << 2U);
  if (levels != levels_) {
    for (unsigned motor = 0; motor < channels_.size(); ++motor) {
      const bool turns_over = (((levels ^ levels_) >> (2 * motor)) & kBoth) != 0;
      if (turns_over && !channels_[motor]->set(0.0)) return false;
    }
    if (!lines_->set(levels)) return false;
    levels_ = levels;
  }
  for (unsigned motor = 0; motor < channels_.size(); ++motor) {
    if (!channels_[motor]->set(std::abs(shares[motor]))) return false;
  }
  return true;
}

bool HBridges::stop() {
  bool all = true;
  for (const auto& channel : channels_) all = channel->set(0.0) && all;
  all = lines_->set(0) && all;
  levels_ = 0;
  return all;
}

bool HBridges::reopen() {
  bool all = true;
  for (const auto& channel : channels_) all = channel->reopen() && all;
  all = lines_->reopen() && all;
  levels_ = 0;
  return all;
}

}  // namespace nacelle::diff_drive
