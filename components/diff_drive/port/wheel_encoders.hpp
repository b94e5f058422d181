// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

/// How far a wheel has turned, as its encoder counts it.
struct WheelCount {
  std::int64_t count = 0;                ///< Never wraps.
  std::optional<MonotonicTime> edge_at;  ///< When it last changed, where that is known.
};

/// The encoders of both wheels.
///
/// Threads: one. Allocates: nothing but in reopen().
class WheelEncoders {
 public:
  struct Stats {
    std::uint64_t edges = 0;  ///< Seen one by one; 0 where the kernel or a chip counts.
    std::uint64_t lost = 0;   ///< Edges that were not seen, as their numbers tell.
  };

  WheelEncoders() = default;
  WheelEncoders(const WheelEncoders&) = delete;
  WheelEncoders& operator=(const WheelEncoders&) = delete;
  virtual ~WheelEncoders() = default;

  /// Returns false if they cannot be read.
  [[nodiscard]] virtual bool read(WheelCount& left, WheelCount& right) = 0;
  /// Which way the motors drive, 1, -1 or 0: for encoders that do not see it. 0: as before, since a wheel runs on.
  virtual void drive(int left, int right) = 0;
  /// Opens them anew; the counts go on. Returns false if they are still gone.
  [[nodiscard]] virtual bool reopen() = 0;
  /// read() must be called at least so often.
  [[nodiscard]] virtual Duration longest_rest() const { return Duration::max(); }
  [[nodiscard]] virtual Stats stats() const { return {}; }
};

}  // namespace nacelle::diff_drive
