// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle::transport_dds {

/// Estimates the offset of a participant's machine's clock from the stamps of its messages and answers.
///
/// A message that takes `late` to arrive, from a clock that is `ahead` of this one, arrives with the age late - ahead.
/// No message is early, so the least age of a window is the best estimate of the offset, and: - a negative age is
/// certain: the clock is ahead by at least that much. It counts above 20 ms, if it occurred in two slices of the window
/// (a single wrong stamp is not a clock offset). - a positive age may also be the travel time. From 20 ms on
/// is_worth_asking(): an answer stamped after the query shows that the clock is behind by at least the query's time
/// minus the stamp, whatever the travel time. From 20 ms on that is reported, and certain. An answer that shows less
/// means that the travel time explains the age, and nothing is reported. - without an answer it counts as behind from
/// 100 ms on (no link of a robot takes 80 ms for its fastest message of
///    16 s), if ten messages and more have come and the least ages of three slices and more agree within 15 ms: a queue's length varies, a clock's offset does not. Once it is reported, 45 ms suffice. When this machine's clock is set, the estimate is reset. Drift within the window is left out: 100 ppm are 1.6 ms.
/// Threads: one. Allocates: nothing. No message, no work.
class PeerClock {
 public:
  static constexpr std::size_t kSlices = 8;
  static constexpr Duration kSlice = 2s, kLeastAhead = 20ms, kLongestWay = 80ms, kAgree = 15ms;
  static constexpr Duration kAskAgain = 30s, kAnswerHolds = 60s;
  static constexpr std::uint32_t kLeastMessages = 10;

  /// Records a message. Returns true if ahead() or is_certain() has changed.
  bool note(WallTime source, WallTime received, MonotonicTime at);
  /// Returns how far the clock is ahead of this one, negative if it is behind; 0: not known to differ. It stays
  /// constant while the estimate changes by less than 20 ms or a quarter.
  [[nodiscard]] Duration ahead() const { return told_.ahead; }
  /// Returns whether the offset is at least that much. Otherwise the messages may be late instead.
  [[nodiscard]] bool is_certain() const { return told_.is_certain; }
  /// Returns the window's least age, for tools. Duration::max(): no messages.
  [[nodiscard]] Duration least_age() const;

  /// Returns true if the ages alone are ambiguous. The caller then calls begin_asking(), end_asking() or both. Until
  /// then, and during a query, an ambiguous offset is not reported for the first time.
  [[nodiscard]] bool is_worth_asking(MonotonicTime at) const { return is_in_doubt_ && !is_asked_ && at >= ask_at_; }
  void begin_asking() { is_asked_ = true; }
  /// With or without answers; not again for a while.
  void end_asking(MonotonicTime at);
  /// One answer: the times of query and arrival by this machine's clocks, and its stamp. Evaluated at the end of the
  /// slice.
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
  Duration ours_{};  ///< This machine's wall clock minus its monotonic clock.
  Belief told_;
  bool is_in_doubt_ = false, is_asked_ = false;
  MonotonicTime ask_at_;
};

}  // namespace nacelle::transport_dds
