// SPDX-License-Identifier: Apache-2.0
#include "drawing/bars.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <regex>

namespace nacelle::drawing {
namespace {

const ChartStyle kPage{svg_page_colours(), SvgPlace::Page, 520, 24};

/// Left end and width of each bar that is 12 pixels high and no mark of the legend.
std::vector<std::pair<double, double>> bars(const std::string& svg) {
  std::vector<std::pair<double, double>> all;
  const std::regex bar{R"re(<rect x="([\d.]+)" y="([\d.]+)" width="([\d.]+)" height="12.0")re"};
  for (std::sregex_iterator at{svg.begin(), svg.end(), bar}; at != std::sregex_iterator{}; ++at) {
    if (std::stod((*at)[2]) > 20.0) all.emplace_back(std::stod((*at)[1]), std::stod((*at)[3]));
  }
  return all;
}

TEST(Bars, have_parts_that_end_at_their_values_on_a_logarithmic_axis) {
  const std::string svg =
      bars_svg({{"p50", "max"}, {{"/a<b", "10 / 1000 us", {1e-5, 1e-3}}, {"/c", "", {1e-4, 1e-3}}}}, kPage);
  const auto all = bars(svg);
  ASSERT_EQ(all.size(), 4U) << svg;
  // From 10 us to 1 ms are two decades: 100 us is in the middle.
  EXPECT_NEAR(all[0].second, 0.0, 0.1);
  EXPECT_NEAR(all[1].second, 488.0, 0.1);
  EXPECT_NEAR(all[2].second, 244.0, 0.1);
  EXPECT_NEAR(all[3].first, 16.0 + 244.0, 0.1);
  EXPECT_NE(svg.find("/a&lt;b"), std::string::npos);
  for (const char* const tick : {">10 us<", ">100 us<", ">1 ms<"}) EXPECT_NE(svg.find(tick), std::string::npos) << tick;
  EXPECT_EQ(svg.find("http"), std::string::npos) << "within a page";
}

TEST(Bars, leave_out_what_is_no_time) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const std::string svg = bars_svg({{"a", "b", "c"}, {{"row", "", {0.0, nan, inf}}, {"other", "", {-1.0}}}}, kPage);
  EXPECT_TRUE(bars(svg).empty()) << svg;
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(bars_svg({}, kPage).find("nan"), std::string::npos);
}

TEST(PowerOfTen, has_the_unit_of_its_size) {
  const std::vector<std::string> expected{"1 ns", "10 ns", "100 ns", "1 us", "10 us", "100 us",
                                          "1 ms", "10 ms", "100 ms", "1 s",  "10 s",  "100 s"};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(power_of_ten_text(static_cast<int>(i) - 9), expected[i]);
}

TEST(SmallLine, goes_from_zero_up_and_has_a_mark) {
  const std::string svg = small_line_svg({"/scan", {{0, 10}, {1, 5}, {2, 10}}}, 10.0, kPage);
  EXPECT_NE(svg.find("points=\"0.0,2.0 260.0,12.0 520.0,2.0\""), std::string::npos) << svg;
  EXPECT_NE(svg.find("<line"), std::string::npos);
  EXPECT_EQ(small_line_svg({"/scan", {{0, 10}, {1, 5}}}, 0.0, kPage).find("<line"), std::string::npos);
  EXPECT_EQ(small_line_svg({"none", {}}, 10.0, kPage).find("<line"), std::string::npos);
  EXPECT_EQ(small_line_svg({"zero", {{0, 0}, {1, 0}}}, 0.0, kPage).find("nan"), std::string::npos);
}

}  // namespace
}  // namespace nacelle::drawing
