// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace nacelle::cli {

struct BagPlotWish {
  std::string path, output;
  std::vector<std::string> fields;  ///< "/odom.pose.pose.position.x"
  std::string x;                    ///< The same; empty: the time.
};

/// Draws fields of a recording into an SVG file, which is replaced if it exists. Returns the exit code: kFailed if the recording cannot be
/// read to its end; what was read is drawn.
int plot_bag(const BagPlotWish& wish);

/// Returns the error of "TOPIC.field", or an empty text; for Option::checked().
[[nodiscard]] std::string wrong_topic_field(const std::string& text);

}  // namespace nacelle::cli
