// SPDX-License-Identifier: Apache-2.0
#include "nacelle/drawing/frame_tree.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

namespace nacelle::drawing {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::vector<FrameEdge> kRobot{{"base_link", "odom", "/ekf", false, 50.0, 0.012},
                                    {"lidar_link", "base_link", "/transforms", true, 0, 0},
                                    {"camera_link", "base_link", "/transforms", true, 0, 0},
                                    {"lens", "camera_link", "", false, 0.5, 3.1}};

TEST(FrameTree, as_text_hangs_each_frame_from_its_parent) {
  EXPECT_EQ(tree_text(kRobot),
            "odom\n"
            "└─ base_link       50.0 Hz, 12 ms old, /ekf\n"
            "   ├─ camera_link  static, /transforms\n"
            "   │  └─ lens      0.5 Hz, 3.1 s old, owner unknown\n"
            "   └─ lidar_link   static, /transforms\n");
}

TEST(FrameTree, shows_every_tree_and_what_hangs_in_a_circle) {
  const std::string text =
      tree_text({{"b", "a", "", true}, {"d", "c", "", true}, {"x", "y", "", true}, {"y", "x", "", true}});
  for (const char* const part : {"a\n└─ b", "c\n└─ d", "x\n└─ y"}) EXPECT_THAT(text, HasSubstr(part));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 6);
  EXPECT_EQ(tree_text({}), "");
}

TEST(FrameTree, for_graphviz_says_on_the_edge_who_and_how_often) {
  const std::string dot = tree_dot(kRobot);
  EXPECT_THAT(dot, HasSubstr("\"odom\" -> \"base_link\" [label=\"50.0 Hz, 12 ms old, /ekf\"];"));
  EXPECT_THAT(dot, HasSubstr("\"camera_link\" -> \"lens\" [label=\"0.5 Hz, 3.1 s old, owner unknown\", color=red"));
}

TEST(FrameTree, as_svg_has_a_box_for_each_frame_and_a_line_for_each_edge) {
  const auto drawn = tree_svg(kRobot);
  ASSERT_TRUE(drawn);
  const std::string& svg = drawn.value();
  const auto count = [&](const std::string& part) {
    const std::regex pattern{part};
    return std::distance(std::sregex_iterator{svg.begin(), svg.end(), pattern}, {});
  };
  EXPECT_THAT(svg, StartsWith("<svg "));
  EXPECT_THAT(svg, testing::EndsWith("</svg>\n"));
  EXPECT_EQ(count("rx=\"4\""), 5);
  EXPECT_EQ(count("<path "), 4);
  EXPECT_EQ(count("stroke=\"crimson\""), 1) << "the one that is old";
}

TEST(FrameTree, no_two_boxes_lie_upon_each_other) {
  std::vector<FrameEdge> edges;
  for (int i = 1; i < 60; ++i)
    edges.push_back({"frame_" + std::to_string(i), "frame_" + std::to_string((i * 7) % i / 2), "/node", true, 0, 0});
  const std::string svg = tree_svg(edges).value();
  const std::regex box{"<rect x=\"([0-9.]+)\" y=\"([0-9.]+)\" width=\"([0-9.]+)\" height=\"([0-9.]+)\" rx"};
  std::vector<std::array<double, 4>> boxes;
  for (auto at = std::sregex_iterator{svg.begin(), svg.end(), box}; at != std::sregex_iterator{}; ++at)
    boxes.push_back({std::stod((*at)[1]), std::stod((*at)[2]), std::stod((*at)[3]), std::stod((*at)[4])});
  ASSERT_EQ(boxes.size(), 60U);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = i + 1; j < boxes.size(); ++j) {
      const auto& a = boxes[i];
      const auto& b = boxes[j];
      EXPECT_TRUE(a[0] + a[2] <= b[0] || b[0] + b[2] <= a[0] || a[1] + a[3] <= b[1] || b[1] + b[3] <= a[1])
          << i << " and " << j;
    }
  }
}

TEST(FrameTree, a_name_cannot_break_the_file) {
  const std::vector<FrameEdge> nasty{{"<b>&\"", "a\\", "", true, 0, 0}};
  EXPECT_THAT(tree_svg(nasty).value(), HasSubstr("&lt;b&gt;&amp;&quot;"));
  EXPECT_THAT(tree_dot(nasty), HasSubstr("\"a\\\\\" -> \"<b>&\\\"\""));
  EXPECT_TRUE(tree_pdf(nasty));
}

/// The offset of an object says where it begins: a reader of the file goes by these.
TEST(FrameTree, as_pdf_is_one_page_whose_table_of_objects_is_right) {
  const auto drawn = tree_pdf(kRobot);
  ASSERT_TRUE(drawn) << drawn.error().text();
  const std::string& pdf = drawn.value();
  EXPECT_THAT(pdf, StartsWith("%PDF-1."));
  EXPECT_THAT(pdf, HasSubstr("%%EOF"));
  EXPECT_THAT(pdf, HasSubstr("/Count 1"));
  EXPECT_THAT(pdf, HasSubstr("(lidar_link)"));
  EXPECT_THAT(pdf, HasSubstr("/Helvetica-Bold"));
  const std::size_t table = std::stoul(pdf.substr(pdf.rfind("startxref") + 10));
  ASSERT_EQ(pdf.compare(table, 4, "xref"), 0);
  const std::regex entry{"([0-9]{10}) 00000 n"};
  int number = 0;
  for (auto at = std::sregex_iterator{pdf.begin() + static_cast<std::ptrdiff_t>(table), pdf.end(), entry};
       at != std::sregex_iterator{}; ++at) {
    const std::string head = std::to_string(++number) + " 0 obj";
    EXPECT_EQ(pdf.compare(std::stoul((*at)[1]), head.size(), head), 0) << head;
  }
  EXPECT_GT(number, 5);
}

TEST(FrameTree, a_tree_larger_than_a_page_may_be_is_made_smaller) {
  std::vector<FrameEdge> chain;
  for (int i = 0; i < 200; ++i)
    chain.push_back({"frame_" + std::to_string(i + 1), "frame_" + std::to_string(i), "/node", true, 0, 0});
  const auto drawn = tree_pdf(chain);
  ASSERT_TRUE(drawn) << drawn.error().text();
  EXPECT_THAT(drawn.value(), HasSubstr("14400"));
}

TEST(ShortTime, is_read_at_a_glance) {
  EXPECT_EQ(short_time(0.0123), "12 ms");
  EXPECT_EQ(short_time(-0.5), "-500 ms");
  EXPECT_EQ(short_time(3.14), "3.1 s");
  EXPECT_EQ(short_time(600), "10 min");
}

}  // namespace
}  // namespace nacelle::drawing
