// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace nacelle::drawing {

/// One edge of the tree of frames.
struct FrameEdge {
  std::string child, parent;
  std::string owner;  ///< The node that broadcasts it; empty: unclaimed.
  bool is_static = false;
  double rate_hz = 0;
  double age_s = 0;  ///< Of its newest sample.
};

/// "50.0 Hz, 12 ms old, /ekf" or "static, /transforms"
[[nodiscard]] std::string describe(const FrameEdge& edge);
/// "12 ms", "3.1 s"; a sample of the future has a minus.
[[nodiscard]] std::string short_time(double seconds);

// Each draws every tree that there is, children by name. Pure; what hangs in a circle hangs from its first frame by name.

/// With lines of box characters, for a terminal.
[[nodiscard]] std::string tree_text(const std::vector<FrameEdge>& edges);
/// In the DOT language, for write_drawing().
[[nodiscard]] std::string tree_dot(const std::vector<FrameEdge>& edges);

}  // namespace nacelle::drawing
