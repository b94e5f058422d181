// SPDX-License-Identifier: Apache-2.0
#include "drawing/bars.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace nacelle::drawing {
namespace {

// Pixels.
constexpr double kSide = 16.0, kLegend = 34.0, kRow = 40.0, kBar = 12.0, kAxis = 30.0;

bool is_time(double value) { return std::isfinite(value) && value > 0.0; }

/// The powers of ten of a second around all values.
struct Decades {
  int low = -6, high = -3;

  explicit Decades(const std::vector<BarRow>& rows) {
    double least = 1e-3, most = 1e-6;
    for (const BarRow& row : rows) {
      for (const double end : row.ends_s) {
        if (!is_time(end)) continue;
        least = std::min(least, end);
        most = std::max(most, end);
      }
    }
    low = std::max(-9, static_cast<int>(std::floor(std::log10(least))));
    high = std::max(low + 1, static_cast<int>(std::ceil(std::log10(most))));
  }
  /// Returns 0 at the lowest, 1 at the highest.
  [[nodiscard]] double part(double seconds) const { return (std::log10(seconds) - low) / (high - low); }
};

}  // namespace

std::string power_of_ten_text(int power) {
  const int group = std::clamp(static_cast<int>(std::floor(power / 3.0)), -3, 0);
  const char* const unit = group == -3 ? "ns" : group == -2 ? "us" : group == -1 ? "ms" : "s";
  return fmt::format("{:.0f} {}", std::pow(10.0, power - 3 * group), unit);
}

std::string bars_svg(const BarChart& chart, const ChartStyle& style) {
  const SvgColours& colours = style.colours;
  const Decades decades{chart.rows};
  const double width = style.width - 2 * kSide;
  const double bottom = kLegend + kRow * static_cast<double>(chart.rows.size());
  const auto at = [&](double seconds) { return kSide + std::clamp(decades.part(seconds), 0.0, 1.0) * width; };

  SvgPage page{style.width, bottom + kAxis, colours, style.place};
  for (int power = decades.low; power <= decades.high; ++power) {
    const double x = at(std::pow(10.0, power));
    page.line({x, kLegend}, {x, bottom}, colours.grid, 1.0);
    const SvgAnchor anchor = power == decades.low    ? SvgAnchor::Start
                             : power == decades.high ? SvgAnchor::End
                                                     : SvgAnchor::Middle;
    page.text({x, bottom + 18}, power_of_ten_text(power), anchor);
  }
  double legend = kSide;
  for (std::size_t i = 0; i < chart.parts.size(); ++i) {
    page.bar({legend, 8}, {legend + kBar, 8 + kBar}, colours.of_line(i), "");
    page.text({legend + kBar + 6, 19}, chart.parts[i], SvgAnchor::Start);
    legend += kBar + 40 + 8 * static_cast<double>(chart.parts[i].size());
  }
  double y = kLegend;
  for (const BarRow& row : chart.rows) {
    page.text({kSide, y + 16}, row.name, SvgAnchor::Start);
    page.text({kSide + width, y + 16}, row.figures, SvgAnchor::End);
    double left = kSide;
    for (std::size_t i = 0; i < row.ends_s.size(); ++i) {
      if (!is_time(row.ends_s[i])) continue;
      const double right = std::max(left, at(row.ends_s[i]));
      page.bar({left, y + 22}, {right, y + 22 + kBar}, colours.of_line(i),
               i < chart.parts.size() ? chart.parts[i] : "");
      left = right;
    }
    y += kRow;
  }
  return page.text();
}

std::string small_line_svg(const ChartLine& line, double mark, const ChartStyle& style) {
  const auto points = thinned(line.points, static_cast<int>(style.width));
  SvgPage page{style.width, style.plot_height, style.colours, style.place};
  if (points.empty()) return page.text();
  double most = std::max(mark, 1e-300);
  for (const ChartPoint& point : points) most = std::max(most, point.y);
  const double low = points.front().x, size = points.back().x - low;
  const auto at_y = [&](double value) { return style.plot_height - 2 - value / most * (style.plot_height - 4); };
  if (mark > 0.0) page.line({0, at_y(mark)}, {style.width, at_y(mark)}, style.colours.frame, 1.0);
  std::vector<SvgPoint> places;
  for (const ChartPoint& point : points)
    places.push_back({size > 0.0 ? (point.x - low) / size * style.width : 0.0, at_y(point.y)});
  page.polyline(places, style.colours.of_line(0), 1.8, line.name);
  return page.text();
}

}  // namespace nacelle::drawing
