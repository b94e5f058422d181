// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

/// Finds the readings of two wheels that belong together, where each wheel's board reports by itself.
///
/// Two readings are a pair if they arrived close to each other: within 0.6 of the period at which the boards report, which is
/// learnt, so that boards that report at different phases still make pairs. A reading that is lost costs one pair; the next one of
/// the other wheel is not paired with what came a period earlier.
/// Threads: one. Allocates: nothing.
class WheelPairing {
 public:
  /// A reading of wheel 0 (left) or 1 arrived. Returns whether it makes a pair with the other wheel's last one; both are used up then.
  /// Times do not go back.
  [[nodiscard]] bool hear(std::size_t wheel, MonotonicTime at);
  void restart();
  /// The longest time between two readings of a pair.
  [[nodiscard]] Duration window() const;

 private:
  void learn(Duration interval);

  std::array<std::optional<MonotonicTime>, 2> heard_;     // last
  std::array<std::optional<MonotonicTime>, 2> unpaired_;  // last, if no pair has used it
  Duration period_{};
};

}  // namespace nacelle::diff_drive
