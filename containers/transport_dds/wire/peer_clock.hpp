// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "nacelle/base/time.hpp"

namespace nacelle::transport_dds {

/// What the stamps of one participant's messages say of its machine's clock beside ours.
///
/// A message that is `late` on its way from a clock that is `ahead` of ours shows, at its coming, the age late - ahead.
/// Nothing is early, so the least age of a window is the offset as well as it can be known, and:
///  - a negative age is certain: the clock is ahead by that much at least. Over 20 ms it counts, once it was seen in two
///    slices of the window (one wild stamp is no clock).
///  - a positive age may as well be the way. It counts as behind from 100 ms on (no link of a robot takes 80 ms for its
///    fastest message of 16 s), if ten messages and more have come and the least ages of three slices and more agree within
///    15 ms: a queue's length wanders, a clock's offset does not. Once it is told, 45 ms are near enough.
/// When our own clock is set, all begins anew. Drift within the window is left out: 100 ppm are 1.6 ms.
/// Threads: one. Allocates: nothing. No message, no work.
class PeerClock {
 public:
  static constexpr std::size_t kSlices = 8;
  static constexpr Duration kSlice = 2s, kLeastAhead = 20ms, kLongestWay = 80ms, kAgree = 15ms;
  static constexpr std::uint32_t kLeastMessages = 10;

  /// A message came. True if ahead() has become another.
  bool note(WallTime source, WallTime received, MonotonicTime at);
  /// How far the clock is ahead of ours, negative if it is behind; 0: not known to differ. It keeps still while the
  /// estimate changes by less than 20 ms or a quarter.
  [[nodiscard]] Duration ahead() const { return told_; }
  /// The window's least age: what there is to know, for tools. Duration::max(): nothing came.
  [[nodiscard]] Duration least_age() const;

 private:
  struct Slice {
    std::int64_t number = -1;  ///< Since the monotonic clock's origin; others are empty.
    Duration least = Duration::max();
    std::uint32_t messages = 0;
  };
  [[nodiscard]] bool is_in_window(const Slice& slice) const;
  [[nodiscard]] Duration estimate() const;
  bool judge();

  std::array<Slice, kSlices> slices_{};
  std::int64_t current_ = -1;
  Duration ours_{};  ///< Our wall clock less our monotonic one.
  Duration told_{};
};

}  // namespace nacelle::transport_dds
