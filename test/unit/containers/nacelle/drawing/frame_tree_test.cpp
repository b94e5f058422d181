// SPDX-License-Identifier: Apache-2.0
#include "drawing/frame_tree.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace nacelle::drawing {
namespace {

using testing::HasSubstr;

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

TEST(FrameTree, as_text_has_one_line_for_each_frame_whatever_its_name_is) {
  EXPECT_EQ(tree_text({{"a\x1b[2J\nb", "odom", "/x\r", true}}), "odom\n└─ a\\x1b[2J\\x0ab  static, /x\\x0d\n");
}

TEST(FrameTree, for_graphviz_labels_edges_with_owner_and_rate) {
  const std::string dot = tree_dot(kRobot);
  EXPECT_THAT(dot, HasSubstr("\"odom\" -> \"base_link\" [label=\"50.0 Hz, 12 ms old, /ekf\"];"));
  EXPECT_THAT(dot, HasSubstr("\"camera_link\" -> \"lens\" [label=\"0.5 Hz, 3.1 s old, owner unknown\", color=red"));
}

TEST(FrameTree, a_name_cannot_break_the_file) {
  const std::vector<FrameEdge> nasty{{"<b>&\"", "a\\", "", true, 0, 0}};
  EXPECT_THAT(tree_dot(nasty), HasSubstr("\"a\\\\\" -> \"<b>&\\\"\""));
}

TEST(ShortTime, is_read_at_a_glance) {
  EXPECT_EQ(short_time(0.0123), "12 ms");
  EXPECT_EQ(short_time(-0.5), "-500 ms");
  EXPECT_EQ(short_time(3.14), "3.1 s");
  EXPECT_EQ(short_time(600), "10 min");
}

}  // namespace
}  // namespace nacelle::drawing
