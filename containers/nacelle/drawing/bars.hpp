// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "drawing/chart.hpp"

namespace nacelle::drawing {

struct BarRow {
  std::string name, figures;     ///< Above the bar, at its left and right.
  std::vector<double> ends_s{};  ///< Where its parts end, rising. One that is not above 0, or not finite, is left out.
};

/// Bars of times over one logarithmic axis.
struct BarChart {
  std::vector<std::string> parts;  ///< Of each bar, for the legend: "p50", "p99", "max".
  std::vector<BarRow> rows;
};

/// Returns the bars as an SVG picture. `style`: the height comes from the rows. Pure.
[[nodiscard]] std::string bars_svg(const BarChart& chart, const ChartStyle& style);

/// Returns a power of ten of a second: "1 us", "100 ms", "10 s".
[[nodiscard]] std::string power_of_ten_text(int power);

/// Returns a line without axes, from 0 up, as a small SVG picture. `mark`: a value that a thin line shows; 0: none.
/// Pure.
[[nodiscard]] std::string small_line_svg(const ChartLine& line, double mark, const ChartStyle& style);

}  // namespace nacelle::drawing
