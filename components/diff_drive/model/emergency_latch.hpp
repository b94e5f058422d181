// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

/// An emergency stop of several senders (a button, a person at a terminal, a safety program).
///
/// A set always takes effect, even if its stamp is older than the last release. A release counts if its stamp is newer
/// than the last set: a late joiner receives messages sender by sender, not in order of time.
class EmergencyLatch {
 public:
  /// Returns whether the stop is set now.
  bool take(bool set, MonotonicTime said_at) {
    if (set) {
      is_set_ = true;
      set_at_ = std::max(set_at_, said_at);
    } else if (said_at >= set_at_) {
      is_set_ = false;
    }
    return is_set_;
  }
  [[nodiscard]] bool is_set() const { return is_set_; }

 private:
  bool is_set_ = false;
  MonotonicTime set_at_{};
};

}  // namespace nacelle::diff_drive
