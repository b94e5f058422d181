// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle::transport_dds {

/// What the stamps of one participant's messages, and its answers, say of its machine's clock beside ours.
///
/// A message that is `late` on its way from a clock that is `ahead` of ours shows, at its coming, the age late - ahead.
/// Nothing is early, so the least age of a window is the offset as well as it can be known, and:
///  - a negative age is certain: the clock is ahead by that much at least. Over 20 ms it counts, once it was seen in two
///    slices of the window (one wild stamp is no clock).
///  - a positive age may as well be the way. From 20 ms on is_worth_asking(): what was stamped after we asked is behind by
///    our time then less the stamp at least, however long the way. From 20 ms on that is told, and it is certain; an
///    answer that shows less says that the way explains what is late, and then nothing is told.
///  - without an answer it counts as behind from 100 ms on (no link of a robot takes 80 ms for its fastest message of
///    16 s), if ten messages and more have come and the least ages of three slices and more agree within 15 ms: a queue's
///    length wanders, a clock's offset does not. Once it is told, 45 ms are near enough.
/// When our own clock is set, all begins anew. Drift within the window is left out: 100 ppm are 1.6 ms.
/// Threads: one. Allocates: nothing. No message, no work.
class PeerClock {
 public:
  static constexpr std::size_t kSlices = 8;
  static constexpr Duration kSlice = 2s, kLeastAhead = 20ms, kLongestWay = 80ms, kAgree = 15ms;
  static constexpr Duration kAskAgain = 30s, kAnswerHolds = 60s;
  static constexpr std::uint32_t kLeastMessages = 10;

  /// A message came. True if ahead() or is_certain() has become another.
  bool note(WallTime source, WallTime received, MonotonicTime at);
  /// How far the clock is ahead of ours, negative if it is behind; 0: not known to differ. It keeps still while the
  /// estimate changes by less than 20 ms or a quarter.
  [[nodiscard]] Duration ahead() const { return told_.ahead; }
  /// It is so by that much at least. Else the messages may come that late.
  [[nodiscard]] bool is_certain() const { return told_.is_certain; }
  /// The window's least age: what there is to know, for tools. Duration::max(): nothing came.
  [[nodiscard]] Duration least_age() const;

  /// Ages alone leave it open. Whoever sees it calls begin_asking(), end_asking() or both: until then, and while one asks,
  /// nothing is told for the first time that may be the way.
  [[nodiscard]] bool is_worth_asking(MonotonicTime at) const { return is_in_doubt_ && !is_asked_ && at >= ask_at_; }
  void begin_asking() { is_asked_ = true; }
  /// With or without answers; not again for a while.
  void end_asking(MonotonicTime at);
  /// One answer, by our clocks when we asked and when it came, and its stamp. The end of the slice looks at it.
  struct Answer {
    WallTime asked;
    MonotonicTime asked_at;
    WallTime source;
    WallTime came;
    MonotonicTime came_at;
  };
  void note_answer(const Answer& answer);

 private:
  struct Slice {
    std::int64_t number = -1;  ///< Since the monotonic clock's origin; others are empty.
    Duration least = Duration::max();
    std::uint32_t messages = 0;
  };
  /// The clock was not ahead by more than that.
  struct Bound {
    Duration most_ahead = Duration::max();  ///< max(): none.
    MonotonicTime at;
  };
  struct Belief {
    Duration ahead{};
    bool is_certain = false;
    friend bool operator==(const Belief&, const Belief&) = default;
  };
  void begin_anew();
  [[nodiscard]] bool is_in_window(const Slice& slice) const;
  [[nodiscard]] Belief estimate(MonotonicTime at) const;
  void drop_what_is_over(MonotonicTime at);
  [[nodiscard]] std::optional<Duration> most_ahead(MonotonicTime at) const;
  bool judge(MonotonicTime at);

  std::array<Slice, kSlices> slices_{};
  std::array<Bound, 6> bounds_{};  // of the last answers
  std::size_t next_bound_ = 0;
  std::int64_t current_ = -1;
  Duration ours_{};  ///< Our wall clock less our monotonic one.
  Belief told_;
  bool is_in_doubt_ = false, is_asked_ = false;
  MonotonicTime ask_at_;
};

}  // namespace nacelle::transport_dds
