// SPDX-License-Identifier: Apache-2.0
#include "drawing/chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "drawing/svg.hpp"

namespace nacelle::drawing {
namespace {

// Pixels.
constexpr double kRight = 24.0, kTop = 20.0, kBottom = 58.0;
constexpr double kLetter = 7.6;                 // the width of a letter of the text, a little more than that of most
constexpr double kXTick = 72.0, kYTick = 40.0;  // the room of a tick
constexpr double kLegendRow = 22.0, kLegendLine = 26.0, kLegendGap = 28.0;

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double size() const { return high - low; }
  /// Makes room around the values, and for a single one.
  void widen(double part) {
    if (low > high) *this = {0.0, 1.0};
    double by = size() * part;
    // Beside a large number, what can be told apart from it.
    const double least = std::max({std::abs(low), std::abs(high), 1e-300}) * 1e-12;
    if (size() <= least) by = low == 0.0 ? 1.0 : std::abs(low) * 0.1;
    low -= by;
    high += by;
  }
  /// Grows to this size on both sides.
  void grow_to(double wanted) {
    const double by = std::max(0.0, wanted - size()) / 2;
    low -= by;
    high += by;
  }
};

int ticks_in(double room, double each) { return std::max(2, static_cast<int>(room / each)); }

bool is_finite(const ChartPoint& point) { return std::isfinite(point.x) && std::isfinite(point.y); }

/// The legend's rows, in the order of the lines.
std::vector<std::vector<std::size_t>> legend_rows(const std::vector<ChartLine>& lines, double width) {
  std::vector<std::vector<std::size_t>> rows;
  double used = 0.0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double more = kLegendLine + 8 + kLetter * static_cast<double>(lines[i].name.size()) + kLegendGap;
    if (rows.empty() || used + more > width) {
      rows.emplace_back();
      used = 0.0;
    }
    rows.back().push_back(i);
    used += more;
  }
  return rows;
}

/// Where the chart's values are on the page.
struct Frame {
  double left = 0.0, top = 0.0, width = 0.0, height = 0.0;
  Range x, y;

  [[nodiscard]] double at_x(double value) const { return left + (value - x.low) / x.size() * width; }
  [[nodiscard]] double at_y(double value) const { return top + (y.high - value) / y.size() * height; }
};

std::size_t longest_text(const AxisTicks& ticks) {
  std::size_t longest = 1;
  for (const double value : ticks.values) longest = std::max(longest, ticks.text(value).size());
  return longest;
}

void draw_line(SvgPage& page, const Frame& frame, const ChartLine& line, const std::string& colour) {
  const auto points = thinned(line.points, static_cast<int>(frame.width));
  std::vector<SvgPoint> part;
  const auto end_part = [&] {
    if (part.size() == 1) page.dot(part.front(), 2.5, colour);
    if (part.size() > 1) page.polyline(part, colour, 1.8, line.name);
    part.clear();
  };
  for (const ChartPoint& point : points) {
    if (is_finite(point))
      part.push_back({frame.at_x(point.x), frame.at_y(point.y)});
    else
      end_part();
  }
  end_part();
}

void draw_axes(SvgPage& page, const Frame& frame, const Chart& chart, const AxisTicks& x, const AxisTicks& y,
               const SvgColours& colours) {
  const double right = frame.left + frame.width, bottom = frame.top + frame.height;
  for (const double value : x.values) {
    page.line({frame.at_x(value), frame.top}, {frame.at_x(value), bottom}, colours.grid, 1.0);
    page.text({frame.at_x(value), bottom + 18}, x.text(value), SvgAnchor::Middle);
  }
  for (const double value : y.values) {
    page.line({frame.left, frame.at_y(value)}, {right, frame.at_y(value)}, colours.grid, 1.0);
    page.text({frame.left - 8, frame.at_y(value) + 4.5}, y.text(value), SvgAnchor::End);
  }
  page.frame({frame.left, frame.top}, {right, bottom}, colours.frame);
  page.text({frame.left + frame.width / 2, bottom + 42}, chart.x_label, SvgAnchor::Middle);
  if (!chart.y_label.empty()) page.text_upwards({20, frame.top + frame.height / 2}, chart.y_label);
}

void draw_legend(SvgPage& page, const Frame& frame, const std::vector<ChartLine>& lines,
                 const std::vector<std::vector<std::size_t>>& rows, const SvgColours& colours) {
  double y = kTop;
  for (const auto& row : rows) {
    double x = frame.left;
    for (const std::size_t i : row) {
      page.line({x, y}, {x + kLegendLine, y}, colours.of_line(i), 3.0);
      page.text({x + kLegendLine + 8, y + 4.5}, lines[i].name, SvgAnchor::Start);
      x += kLegendLine + 8 + kLetter * static_cast<double>(lines[i].name.size()) + kLegendGap;
    }
    y += kLegendRow;
  }
}

}  // namespace

std::string AxisTicks::text(double value) const {
  const double size = std::max(std::abs(value), step);
  if (std::abs(value) < step / 2) return "0";
  if (size >= 1e7 || step < 1e-6) {
    // As many digits as tell two ticks apart.
    const int digits = std::clamp(static_cast<int>(std::floor(std::log10(size)) - std::floor(std::log10(step))), 0, 16);
    return svg_number_scientific(value, digits);
  }
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  return svg_number(value, decimals);
}

AxisTicks axis_ticks(double low, double high, int most) {
  AxisTicks ticks;
  const double size = high - low;
  if (!(size > 0.0) || !std::isfinite(size)) {
    ticks.step = low == 0.0 || !std::isfinite(low) ? 1.0 : std::pow(10.0, std::floor(std::log10(std::abs(low))));
    ticks.values = {low};
    return ticks;
  }
  const double rough = size / (most - 1);  // n intervals have n + 1 ticks
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0, 10.0}) {
    ticks.step = factor * power;
    if (ticks.step >= rough * (1 - 1e-9)) break;
  }
  // A tick that rounding puts just outside is one.
  const auto first = std::ceil(low / ticks.step - 1e-6), last = std::floor(high / ticks.step + 1e-6);
  for (double i = first; i <= last && ticks.values.size() < static_cast<std::size_t>(most); ++i)
    ticks.values.push_back(i * ticks.step);
  return ticks;
}

std::vector<ChartPoint> thinned(const std::vector<ChartPoint>& points, int columns) {
  const bool goes_right =
      std::is_sorted(points.begin(), points.end(), [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
  if (columns < 1 || points.size() <= 2 * static_cast<std::size_t>(columns) || !goes_right ||
      !std::all_of(points.begin(), points.end(), is_finite))
    return points;
  const double low = points.front().x, size = points.back().x - low;
  const auto column_of = [&](const ChartPoint& point) {
    return size > 0.0 ? std::floor((point.x - low) / size * columns) : 0.0;
  };
  const auto is_lower = [](const ChartPoint& a, const ChartPoint& b) { return a.y < b.y; };
  std::vector<ChartPoint> kept;
  for (auto begin = points.begin(); begin != points.end();) {
    const double column = column_of(*begin);
    const auto end =
        std::find_if(begin, points.end(), [&](const ChartPoint& point) { return column_of(point) != column; });
    std::array places{begin, std::min_element(begin, end, is_lower), std::max_element(begin, end, is_lower),
                      std::prev(end)};
    std::sort(places.begin(), places.end());
    const auto last = std::unique(places.begin(), places.end());
    std::for_each(places.begin(), last, [&](const auto& place) { kept.push_back(*place); });
    begin = end;
  }
  return kept;
}

std::string chart_svg(const Chart& chart, const ChartStyle& style) {
  const SvgColours& colours = style.colours;
  Frame frame;
  for (const ChartLine& line : chart.lines) {
    for (const ChartPoint& point : line.points) {
      if (!is_finite(point)) continue;
      frame.x.add(point.x);
      frame.y.add(point.y);
    }
  }
  frame.x.widen(chart.equal_scales ? 0.05 : 0.0);
  const bool from_zero = chart.y_from_zero && frame.y.low >= 0.0;
  if (from_zero && frame.y.high >= 0.0) frame.y.add(0.0);
  frame.y.widen(0.05);
  if (from_zero) frame.y.low = 0.0;
  frame.height = style.plot_height;
  AxisTicks y = axis_ticks(frame.y.low, frame.y.high, ticks_in(frame.height, kYTick));
  const double label = chart.y_label.empty() ? 0.0 : 22.0;
  frame.left = 22.0 + label + kLetter * static_cast<double>(longest_text(y));
  frame.width = style.width - frame.left - kRight;
  if (chart.equal_scales) {
    // The page has the path's shape within limits; the rest is empty space around it.
    frame.height = std::clamp(frame.width * frame.y.size() / frame.x.size(), 260.0, 760.0);
    const double units_per_pixel = std::max(frame.x.size() / frame.width, frame.y.size() / frame.height);
    frame.x.grow_to(units_per_pixel * frame.width);
    frame.y.grow_to(units_per_pixel * frame.height);
    y = axis_ticks(frame.y.low, frame.y.high, ticks_in(frame.height, kXTick));  // of the same steps as x
  }
  const auto rows = legend_rows(chart.lines, frame.width);
  frame.top = kTop + kLegendRow * static_cast<double>(rows.size()) - 4;

  SvgPage page{style.width, frame.top + frame.height + kBottom, colours, style.place};
  AxisTicks x = axis_ticks(frame.x.low, frame.x.high, ticks_in(frame.width, kXTick));
  draw_axes(page, frame, chart, x, y, colours);
  draw_legend(page, frame, chart.lines, rows, colours);
  for (std::size_t i = 0; i < chart.lines.size(); ++i) draw_line(page, frame, chart.lines[i], colours.of_line(i));
  return page.text();
}

}  // namespace nacelle::drawing
