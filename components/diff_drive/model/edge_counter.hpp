// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

/// Counts the edges of one wheel's encoder: of two channels (quadrature), or of one, which does not see the direction.
///
/// Quadrature, forward when A leads B: an edge of A counts forward if A then differs from B, an edge of B if it then equals A. All four edges of a
/// period count. Edges that are missing, as their numbers tell, count in the direction of the last one that is known.
/// Threads: one. Allocates: nothing.
class EdgeCounter {
 public:
  enum class Channel : unsigned char { A, B };

  explicit EdgeCounter(bool has_b) : has_b_(has_b) {}

  /// The levels now, without a count: at the beginning, or after the lines were away. Numbers begin anew.
  void begin(bool a, bool b);
  /// An edge: its new level, its time, and its number on its channel. `is_merged`: it may stand for several; then a level that has not changed
  /// stands for two.
  void edge(Channel channel, bool level, std::uint32_t number, MonotonicTime at, bool is_merged = false);
  /// Edges may be missing, of either channel: until there was one of both, the direction is taken to be as before.
  void gap() { a_.is_known = b_.is_known = false; }
  /// The direction of the motor, for an encoder of one channel; 0: as before.
  void drive(int direction);

  [[nodiscard]] std::int64_t count() const { return count_; }
  [[nodiscard]] std::optional<MonotonicTime> edge_at() const { return edge_at_; }
  [[nodiscard]] std::uint64_t edges() const { return edges_; }
  /// Edges that are missing.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  struct Line {
    bool level = false;
    std::uint32_t number = 0;
    bool is_known = true;  // the level
  };

  const bool has_b_;
  Line a_, b_;
  int direction_ = 1;
  std::int64_t count_ = 0;
  std::optional<MonotonicTime> edge_at_;
  std::uint64_t edges_ = 0, lost_ = 0;
};

}  // namespace nacelle::diff_drive
