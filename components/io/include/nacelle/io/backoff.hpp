// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <utility>

#include "nacelle/base/time.hpp"

namespace nacelle::io {

/// The pauses between attempts to open a device: each twice the one before, up to the longest. Threads: one.
class Backoff {
 public:
  explicit Backoff(Duration first = 50ms, Duration longest = 1s) : first_(first), longest_(longest), next_(first) {}
  /// The pause before the next attempt.
  [[nodiscard]] Duration next() { return std::exchange(next_, std::min(2 * next_, longest_)); }
  /// The device was there: the next loss begins with the shortest pause.
  void reset() { next_ = first_; }

 private:
  Duration first_, longest_, next_;
};

}  // namespace nacelle::io
