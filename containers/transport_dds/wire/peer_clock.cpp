// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/peer_clock.hpp"

#include <algorithm>
#include <cstdlib>

namespace nacelle::transport_dds {
namespace {

constexpr Duration kClockWasSet = 10ms;  // between two messages; what NTP slews in a slice is less

Duration size_of(Duration d) { return d < Duration::zero() ? -d : d; }

}  // namespace

bool PeerClock::note(WallTime source, WallTime received, MonotonicTime at) {
  if (source.since_origin < Duration::zero()) return false;  // DDS's "no stamp"
  const Duration ours = received.since_origin - at.since_origin;
  if (size_of(ours - ours_) > kClockWasSet) {
    slices_ = {};
    current_ = -1;
  }
  ours_ = ours;
  const std::int64_t number = at.since_origin / kSlice;
  // The slice that is over is judged with the first message of the next one.
  const bool changed = current_ >= 0 && number != current_ && judge();
  current_ = number;
  Slice& slice = slices_[static_cast<std::size_t>(number) % kSlices];
  if (slice.number != number) slice = {number, Duration::max(), 0};
  slice.least = std::min(slice.least, received - source);
  ++slice.messages;
  return changed;
}

bool PeerClock::is_in_window(const Slice& slice) const {
  return slice.number >= 0 && slice.number > current_ - static_cast<std::int64_t>(kSlices);
}

Duration PeerClock::least_age() const {
  Duration least = Duration::max();
  for (const Slice& slice : slices_) {
    if (is_in_window(slice)) least = std::min(least, slice.least);
  }
  return least;
}

Duration PeerClock::estimate() const {
  const Duration least = least_age();
  const bool was_ahead = told_ > Duration::zero(), was_behind = told_ < Duration::zero();
  std::size_t seen = 0, ahead = 0;
  std::uint64_t messages = 0;
  Duration most = Duration::min();
  for (const Slice& slice : slices_) {
    if (!is_in_window(slice)) continue;
    ++seen;
    messages += slice.messages;
    most = std::max(most, slice.least);
    if (slice.least <= (was_ahead ? -kLeastAhead / 2 : -kLeastAhead)) ++ahead;
  }
  if (ahead >= 2) return -least;
  if (seen < 3) return told_;  // too little to say anything else
  const Duration enough = kLongestWay + (was_behind ? kLeastAhead / 2 : kLeastAhead);
  const bool is_known = messages >= kLeastMessages && most - least <= (was_behind ? 3 * kAgree : kAgree);
  return is_known && least >= enough ? -least : Duration::zero();
}

bool PeerClock::judge() {
  const Duration now = estimate();
  const Duration change = size_of(now - told_);
  const bool is_other = (now == Duration::zero()) != (told_ == Duration::zero());
  if (!is_other && change < std::max(kLeastAhead, size_of(told_) / 4)) return false;
  told_ = now;
  return change != Duration::zero();
}

}  // namespace nacelle::transport_dds
