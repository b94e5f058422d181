// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "drawing/svg.hpp"

namespace nacelle::drawing {

struct ChartPoint {
  double x = 0.0, y = 0.0;
  friend bool operator==(const ChartPoint&, const ChartPoint&) = default;
};

struct ChartLine {
  std::string name;
  std::vector<ChartPoint> points;  ///< One that is not finite interrupts the line.
};

/// Lines over one pair of axes.
struct Chart {
  std::string x_label, y_label;  ///< Empty: none.
  std::vector<ChartLine> lines;
  bool equal_scales = false;  ///< A unit is as long on both axes: for paths.
  bool y_from_zero = false;   ///< The y axis begins at 0, unless a value is below it.
};

/// How a chart looks.
struct ChartStyle {
  SvgColours colours = svg_file_colours();
  SvgPlace place = SvgPlace::File;
  double width = 900.0, plot_height = 380.0;  ///< Pixels. With equal scales the values have the height.
};

/// The marks of an axis: multiples of `step`, which is 1, 2 or 5 times a power of ten.
struct AxisTicks {
  double step = 1.0;
  std::vector<double> values;

  /// Returns a value of the axis with as many digits as the step needs.
  [[nodiscard]] std::string text(double value) const;
};

/// Returns the ticks between two finite numbers, `most` at most, which is 2 or more. If `high` is not above `low`, returns one.
[[nodiscard]] AxisTicks axis_ticks(double low, double high, int most);

/// Returns the points that are seen: of a line with more points than twice the columns, whose x never decreases, the first, the lowest, the
/// highest and the last of each column. Other lines stay as they are.
[[nodiscard]] std::vector<ChartPoint> thinned(const std::vector<ChartPoint>& points, int columns);

/// Returns the chart as an SVG picture with grid, ticks and legend. Pure.
[[nodiscard]] std::string chart_svg(const Chart& chart, const ChartStyle& style = {});

}  // namespace nacelle::drawing
