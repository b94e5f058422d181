// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/peer_clock.hpp"

#include <algorithm>
#include <cstdlib>

namespace nacelle::transport_dds {
namespace {

constexpr Duration kClockWasSet = 10ms;   // between two messages; what NTP slews in a slice is less
constexpr std::int64_t kDriftIn = 10000;  // of what lies between, one part: 100 ppm
constexpr Duration kPutRight = 5ms;       // by more than that no clock drifts while a bound holds

Duration size_of(Duration d) { return d < Duration::zero() ? -d : d; }

}  // namespace

bool PeerClock::note(WallTime source, WallTime received, MonotonicTime at) {
  if (source.since_origin < Duration::zero()) return false;  // DDS's "no stamp"
  const Duration ours = received.since_origin - at.since_origin;
  if (size_of(ours - ours_) > kClockWasSet) begin_anew();
  ours_ = ours;
  const std::int64_t number = at.since_origin / kSlice;
  // A slice is evaluated with the first message of the next one.
  const bool changed = current_ >= 0 && number != current_ && judge(at);
  current_ = number;
  Slice& slice = slices_[static_cast<std::size_t>(number) % kSlices];
  if (slice.number != number) slice = {number, Duration::max(), 0};
  slice.least = std::min(slice.least, received - source);
  ++slice.messages;
  return changed;
}

void PeerClock::begin_anew() {
  slices_ = {};
  bounds_ = {};
  current_ = -1;
  is_in_doubt_ = false;
  ask_at_ = {};
}

// --- answers ---------------------------------------------------------------------------------------------------------

void PeerClock::end_asking(MonotonicTime at) {
  is_asked_ = false;
  ask_at_ = at + kAskAgain;
}

void PeerClock::note_answer(const Answer& answer) {
  if (answer.source.since_origin < Duration::zero()) return;
  const Duration ours = answer.came.since_origin - answer.came_at.since_origin;
  const Duration before = answer.asked.since_origin - answer.asked_at.since_origin;
  if (size_of(ours - before) > kClockWasSet || size_of(ours - ours_) > kClockWasSet) return;
  bounds_[next_bound_++ % bounds_.size()] = {answer.source - answer.asked, answer.came_at};
}

// A clock whose estimate exceeds its upper bound has been corrected since.
void PeerClock::drop_what_is_over(MonotonicTime at) {
  for (Bound& bound : bounds_) {
    if (bound.most_ahead == Duration::max()) continue;
    const bool is_refuted = std::ranges::any_of(slices_, [&](const Slice& slice) {
      return is_in_window(slice) && slice.number > bound.at.since_origin / kSlice &&
             -slice.least > bound.most_ahead + kPutRight;
    });
    if (is_refuted || at - bound.at > kAnswerHolds) bound = {};
  }
}

std::optional<Duration> PeerClock::most_ahead(MonotonicTime at) const {
  std::optional<Duration> most;
  for (const Bound& bound : bounds_) {
    if (bound.most_ahead == Duration::max()) continue;
    const Duration now = bound.most_ahead + (at - bound.at) / kDriftIn;
    most = most ? std::min(*most, now) : now;
  }
  return most;
}

// --- reporting ----------------------------------------------------------------------------------------------

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

PeerClock::Belief PeerClock::estimate(MonotonicTime at) const {
  const Duration least = least_age(), near = kLeastAhead / 2;
  const bool was_ahead = told_.ahead > Duration::zero(), was_behind = told_.ahead < Duration::zero();
  std::size_t seen = 0, ahead = 0;
  std::uint64_t messages = 0;
  Duration most = Duration::min();
  for (const Slice& slice : slices_) {
    if (!is_in_window(slice)) continue;
    ++seen;
    messages += slice.messages;
    most = std::max(most, slice.least);
    if (slice.least <= (was_ahead ? -near : -kLeastAhead)) ++ahead;
  }
  if (ahead >= 2) return {-least, true};
  if (const auto answered = most_ahead(at)) {
    const bool is_behind = *answered <= (was_behind ? -near : -kLeastAhead);
    return is_behind ? Belief{*answered, true} : Belief{};
  }
  if (seen < 3) return told_;  // too little to say anything else
  if (is_asked_ || is_worth_asking(at)) return was_behind ? told_ : Belief{};
  const Duration enough = kLongestWay + (was_behind ? near : kLeastAhead);
  const bool is_known = messages >= kLeastMessages && most - least <= (was_behind ? 3 * kAgree : kAgree);
  return is_known && least >= enough ? Belief{-least, false} : Belief{};
}

bool PeerClock::judge(MonotonicTime at) {
  drop_what_is_over(at);
  const auto seen = std::ranges::count_if(slices_, [this](const Slice& slice) { return is_in_window(slice); });
  const bool was_behind = told_.ahead < Duration::zero();
  is_in_doubt_ = seen >= 2 && least_age() >= (was_behind ? kLeastAhead / 2 : kLeastAhead);
  const Belief now = estimate(at);
  const Duration change = size_of(now.ahead - told_.ahead);
  const bool is_other = (now.ahead == Duration::zero()) != (told_.ahead == Duration::zero());
  const bool is_as_sure = now.is_certain == told_.is_certain;
  if (!is_other && is_as_sure && change < std::max(kLeastAhead, size_of(told_.ahead) / 4)) return false;
  const bool changed = now != told_;
  told_ = now;
  return changed;
}

}  // namespace nacelle::transport_dds
