// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "joy/model/pad_state.hpp"

namespace nacelle::joy {

/// Decides when the state of a pad is published, as ROS 2's joy: a button at once, an axis when the coalesce interval is over, and an
/// unchanged state at the autorepeat rate.
///
/// Threads: one. Allocates: nothing.
class JoyPacer {
 public:
  struct Settings {
    Duration coalesce = 1ms;  ///< Moves of axes within it are one message; zero: each is one.
    Duration repeat = 50ms;   ///< Zero: an unchanged state is not repeated.
  };

  explicit JoyPacer(const Settings& settings) : settings_(settings) {}

  /// The state changed. Returns whether it is to be published now.
  bool on_change(PadState::Change change, MonotonicTime now);
  [[nodiscard]] bool is_due(MonotonicTime now) const { return next(now + Duration{1}) <= now; }
  /// A change was not published yet.
  [[nodiscard]] bool waits() const { return waits_; }
  void on_published(MonotonicTime now);
  /// Forgets a change that was not published: the pad is lost.
  void restart() { waits_ = false; }
  /// Returns when is_due() becomes true without a further change, at the latest `latest`.
  [[nodiscard]] MonotonicTime next(MonotonicTime latest) const;

 private:
  const Settings settings_;
  bool waits_ = false;
  MonotonicTime changed_{}, published_{};
};

}  // namespace nacelle::joy
