// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace nacelle::drawing {

/// One edge of the frame tree.
struct FrameEdge {
  std::string child, parent;
  std::string owner;  ///< The node that broadcasts it; empty: unknown.
  bool is_static = false;
  double rate_hz = 0;
  double age_s = 0;  ///< Age of its newest sample.
};

/// Returns "50.0 Hz, 12 ms old, /ekf" or "static, /transforms".
[[nodiscard]] std::string describe(const FrameEdge& edge);
/// Returns "12 ms" or "3.1 s"; negative for a sample in the future.
[[nodiscard]] std::string short_time(double seconds);

// Each function draws all trees, with the children sorted by name. A cycle is drawn from its first frame by name. Pure.

/// Returns the trees as lines of box characters, for a terminal.
[[nodiscard]] std::string tree_text(const std::vector<FrameEdge>& edges);
/// Returns the trees in the DOT language, for write_drawing().
[[nodiscard]] std::string tree_dot(const std::vector<FrameEdge>& edges);

}  // namespace nacelle::drawing
