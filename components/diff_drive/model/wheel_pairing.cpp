// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/wheel_pairing.hpp"

#include <algorithm>

namespace nacelle::diff_drive {
namespace {

constexpr Duration kLeastWindow = 5ms;  // frames of one board come within 1 ms; a thread that runs late stamps later
constexpr Duration kBurst = 1ms;        // shorter intervals are frames that waited, read together
constexpr Duration kLongest = 1s;       // a pause is no period

}  // namespace

Duration WheelPairing::window() const { return std::max(kLeastWindow, period_ * 6 / 10); }

// Lost frames make intervals longer, never shorter: short ones count more.
void WheelPairing::learn(Duration interval) {
  if (interval < kBurst || interval > kLongest) return;
  period_ = period_ == Duration::zero() ? interval : period_ + (interval - period_) / (interval < period_ ? 2 : 8);
}

bool WheelPairing::hear(std::size_t wheel, MonotonicTime at) {
  if (heard_[wheel]) learn(at - *heard_[wheel]);
  heard_[wheel] = at;
  auto& other = unpaired_[1 - wheel];
  if (other && at - *other <= window()) {
    unpaired_ = {};
    return true;
  }
  other.reset();
  unpaired_[wheel] = at;
  return false;
}

void WheelPairing::restart() { *this = {}; }

}  // namespace nacelle::diff_drive
