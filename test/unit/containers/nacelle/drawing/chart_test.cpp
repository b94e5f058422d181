// SPDX-License-Identifier: Apache-2.0
#include "drawing/chart.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "drawing/svg.hpp"

namespace nacelle::drawing {
namespace {

std::vector<std::string> texts(double low, double high, int most) {
  const AxisTicks ticks = axis_ticks(low, high, most);
  std::vector<std::string> all;
  for (const double value : ticks.values) all.push_back(ticks.text(value));
  return all;
}

TEST(AxisTicks, are_round) {
  EXPECT_THAT(texts(0.0, 10.0, 6), testing::ElementsAre("0", "2", "4", "6", "8", "10"));
  EXPECT_THAT(texts(-0.13, 0.17, 8), testing::ElementsAre("-0.10", "-0.05", "0", "0.05", "0.10", "0.15"));
  EXPECT_THAT(texts(0.1, 0.7, 7), testing::ElementsAre("0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7"));
  EXPECT_THAT(texts(3.0, 1800.0, 11),
              testing::ElementsAre("200", "400", "600", "800", "1000", "1200", "1400", "1600", "1800"));
  EXPECT_THAT(texts(1.7e9, 1.7e9 + 2.0, 4), testing::ElementsAre("1.700000000e9", "1.700000001e9", "1.700000002e9"));
  EXPECT_THAT(texts(0.0, 3e-9, 4), testing::ElementsAre("0", "1e-9", "2e-9", "3e-9"));
}

TEST(AxisTicks, are_never_more_than_wanted_and_never_outside) {
  for (const double size : {1e-12, 0.3, 0.99, 1.01, 7.0, 49.9, 50.1, 1e15}) {
    for (const double low : {-3.3 * size, 0.0, 0.7 * size}) {
      for (int most = 2; most < 12; ++most) {
        const AxisTicks ticks = axis_ticks(low, low + size, most);
        EXPECT_LE(ticks.values.size(), static_cast<std::size_t>(most)) << low << " " << size;
        const double factor = ticks.step / std::pow(10.0, std::floor(std::log10(ticks.step) + 1e-9));
        EXPECT_TRUE(std::abs(factor - 1) < 1e-6 || std::abs(factor - 2) < 1e-6 || std::abs(factor - 5) < 1e-6)
            << factor;
        for (const double value : ticks.values) {
          EXPECT_GE(value, low - 1e-5 * size);
          EXPECT_LE(value, low + size + 1e-5 * size);
        }
      }
    }
  }
}

TEST(AxisTicks, of_one_value_are_that) {
  EXPECT_THAT(axis_ticks(5.0, 5.0, 4).values, testing::ElementsAre(5.0));
  EXPECT_THAT(axis_ticks(0.0, 0.0, 4).values, testing::ElementsAre(0.0));
  EXPECT_EQ(axis_ticks(0.0, std::numeric_limits<double>::infinity(), 4).values.size(), 1U);
}

TEST(Thinned, keeps_peaks_of_a_long_line) {
  std::vector<ChartPoint> points;
  for (int i = 0; i < 100'000; ++i) points.push_back({i * 0.001, std::sin(i * 0.1)});
  points[54'321].y = 9.0;
  points[12'345].y = -7.0;
  const auto kept = thinned(points, 800);
  EXPECT_LE(kept.size(), 4U * 801U);
  EXPECT_GT(kept.size(), 800U);
  EXPECT_EQ(kept.front(), points.front());
  EXPECT_EQ(kept.back(), points.back());
  EXPECT_THAT(kept, testing::Contains(points[54'321]));
  EXPECT_THAT(kept, testing::Contains(points[12'345]));
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end(), [](auto& a, auto& b) { return a.x < b.x; }));
}

TEST(Thinned, leaves_paths_and_short_lines_as_they_are) {
  std::vector<ChartPoint> circle;
  for (int i = 0; i < 5'000; ++i) circle.push_back({std::cos(i * 0.01), std::sin(i * 0.01)});
  EXPECT_EQ(thinned(circle, 800), circle);
  const std::vector<ChartPoint> few{{0, 1}, {1, 2}};
  EXPECT_EQ(thinned(few, 800), few);
  const std::vector<ChartPoint> same(3'000, {1.0, 2.0});
  EXPECT_EQ(thinned(same, 800).size(), 2U) << "of one column the first and the last";
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++found;
  return found;
}

TEST(ChartSvg, has_lines_labels_and_a_legend) {
  const std::string svg =
      chart_svg({"time [s]", "speed", {{"a<b", {{0, 0}, {1, 1}}}, {"other", {{0, 2}, {1, 1}}}}, false});
  EXPECT_TRUE(svg.starts_with("<svg xmlns=")) << svg;
  EXPECT_TRUE(svg.ends_with("</svg>\n"));
  EXPECT_EQ(count(svg, "<polyline"), 2U);
  EXPECT_EQ(count(svg, "a&lt;b"), 2U) << "in the legend and as title";
  EXPECT_EQ(count(svg, "time [s]"), 1U);
  EXPECT_EQ(count(svg, "rotate(-90)"), 1U);
  EXPECT_EQ(count(svg, "nan"), 0U);
}

TEST(ChartSvg, interrupts_a_line_where_there_is_no_number) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string svg =
      chart_svg({"", "", {{"a", {{0, 0}, {1, 1}, {2, nan}, {3, 1}, {4, 2}, {5, nan}, {6, 3}}}}, false});
  EXPECT_EQ(count(svg, "<polyline"), 2U);
  EXPECT_EQ(count(svg, "<circle"), 1U) << "of a single point";
  EXPECT_EQ(count(svg, "nan"), 0U);
}

TEST(ChartSvg, is_drawn_without_any_number) {
  for (const double value : {0.0, 1e300, -1e-300, 7.0}) {
    const std::string svg = chart_svg({"", "", {{"constant", {{1, value}, {2, value}}}}, false});
    EXPECT_EQ(count(svg, "nan") + count(svg, "inf"), 0U) << svg;
    EXPECT_EQ(count(svg, "<polyline"), 1U);
  }
  EXPECT_EQ(count(chart_svg({"", "", {{"empty", {}}}, true}), "nan"), 0U);
}

/// The places of the first line.
std::vector<SvgPoint> places(const std::string& svg) {
  std::vector<SvgPoint> all;
  const std::size_t begin = svg.find("points=\"") + 8;
  const std::string text = svg.substr(begin, svg.find('"', begin) - begin);
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t comma = text.find(',', at), end = std::min(text.find(' ', at), text.size());
    all.push_back({std::stod(text.substr(at, comma - at)), std::stod(text.substr(comma + 1, end - comma - 1))});
    at = end + 1;
  }
  return all;
}

TEST(ChartSvg, has_equal_scales_for_a_path) {
  for (const double height : {0.01, 1.0, 30.0}) {
    const auto at = places(chart_svg({"x", "y", {{"path", {{0, 0}, {3, 0}, {3, height}}}}, true}));
    ASSERT_EQ(at.size(), 3U);
    const double across = (at[1].x - at[0].x) / 3.0, up = (at[1].y - at[2].y) / height;
    EXPECT_NEAR(up / across, 1.0, 0.2 / height / across + 0.01) << "places have a tenth of a pixel";
  }
}

TEST(ChartSvg, within_a_page_has_the_pages_colours_and_no_paper) {
  const std::string svg =
      chart_svg({"", "", {{"a", {{0, 0}, {1, 1}}}}, false}, {svg_page_colours(), SvgPlace::Page, 520, 240});
  EXPECT_TRUE(svg.starts_with("<svg viewBox=\"0 0 520 ")) << svg;
  EXPECT_NE(svg.find("stroke=\"var(--line0)\""), std::string::npos);
  EXPECT_EQ(count(svg, "http") + count(svg, "#"), 0U) << "neither a name space nor a colour of its own";
}

TEST(ChartSvg, begins_at_zero_on_demand_unless_a_value_is_below) {
  const auto first_tick = [](double low) {
    const std::string svg = chart_svg({"", "", {{"a", {{0, low}, {1, 24}}}}, false, true});
    const std::string text = svg.substr(svg.find("text-anchor=\"end\">") + 18);
    return text.substr(0, text.find('<'));
  };
  EXPECT_EQ(first_tick(23), "0");
  EXPECT_EQ(first_tick(-10).front(), '-');
}

TEST(SvgText, replaces_what_xml_cannot_have) {
  EXPECT_EQ(svg_text("a<b>&\"c\""), "a&lt;b&gt;&amp;&quot;c&quot;");
  EXPECT_EQ(svg_text("Fahrt \xC3\xBC"), "Fahrt \xC3\xBC");
  EXPECT_EQ(svg_text("a\x1b[1mb\n"), "a\xEF\xBF\xBD[1mb\xEF\xBF\xBD");
  EXPECT_EQ(svg_text("a\xFF"), "a\xEF\xBF\xBD") << "no UTF-8";
  EXPECT_EQ(svg_text("a\xC3"), "a\xEF\xBF\xBD") << "cut within a character";
  EXPECT_EQ(svg_text("a\xEF\xBF\xBEz"), "a\xEF\xBF\xBDz") << "U+FFFE";
}

TEST(SvgNumber, has_no_minus_zero) {
  EXPECT_EQ(svg_number(-0.01, 1), "0.0");
  EXPECT_EQ(svg_number(-0.06, 1), "-0.1");
  EXPECT_EQ(svg_number_scientific(-1.5e-12, 1), "-1.5e-12");
  EXPECT_EQ(svg_number_scientific(2e100, 0), "2e100");
}

}  // namespace
}  // namespace nacelle::drawing
