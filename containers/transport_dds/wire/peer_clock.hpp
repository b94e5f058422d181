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
/// No message arrives before it is sent, so the least age in the window (8 slices of 2 s) is the best estimate:
/// - A negative age is certain: the clock is ahead by at least that much. It is reported from 20 ms on, if it occurred
///   in two slices: a single wrong stamp is not a clock offset.
/// - A positive age may also be travel time. From 20 ms on, is_worth_asking() is true. An answer is stamped after the
///   query was sent, so it proves that the clock is behind by at least the query's time minus the stamp, whatever the
///   travel time. From 20 ms on this is reported as certain. If the answer proves less, the travel time explains the
///   age, and nothing is reported.
/// - Without an answer, the clock is reported as behind, but not as certain, from 100 ms on: 80 ms are more than a
///   robot's link takes for its fastest message in 16 s. This requires ten messages, and three slices whose least ages
///   agree within 15 ms: the length of a queue varies, the offset of a clock does not.
/// Once an offset is reported, 10 ms suffice instead of 20 ms, 90 ms instead of 100 ms, and agreement within 45 ms. If
/// this machine's clock is set, the window and the answers are discarded; the reported offset stays until new messages
/// change it. Drift within the window is ignored: 100 ppm are 1.6 ms.
/// Threads: one. Allocates: nothing. Works only when messages arrive; it has no timer.
class PeerClock {
 public:
  static constexpr std::size_t kSlices = 8;
  static constexpr Duration kSlice = 2s, kLeastAhead = 20ms, kLongestWay = 80ms, kAgree = 15ms;
  static constexpr Duration kAskAgain = 30s, kAnswerHolds = 60s;
  static constexpr std::uint32_t kLeastMessages = 10;

  /// Records a message. Returns true if ahead() or is_certain() has changed.
  bool note(WallTime source, WallTime received, MonotonicTime at);
  /// Returns how far the clock is ahead of this one, negative if it is behind; 0: not known to differ. The value stays
  /// constant while the estimate changes by less than 20 ms or by less than a quarter.
  [[nodiscard]] Duration ahead() const { return told_.ahead; }
  /// Returns whether the offset is proven to be at least that much. Otherwise the messages may be late instead.
  [[nodiscard]] bool is_certain() const { return told_.is_certain; }
  /// Returns the least age in the window, for tools. Duration::max(): no messages.
  [[nodiscard]] Duration least_age() const;

  /// Returns true if the ages alone are ambiguous. The caller then calls begin_asking(), end_asking() or both. Until
  /// then, and during a query, an ambiguous offset is not reported for the first time.
  [[nodiscard]] bool is_worth_asking(MonotonicTime at) const { return is_in_doubt_ && !is_asked_ && at >= ask_at_; }
  void begin_asking() { is_asked_ = true; }
  /// Ends a query, with or without answers. is_worth_asking() is false for the next 30 s.
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
    std::int64_t number = -1;  ///< Counted from the monotonic clock's origin. A slice outside the window is empty.
    Duration least = Duration::max();
    std::uint32_t messages = 0;
  };
  /// An upper bound of the offset at a time, from an answer.
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
