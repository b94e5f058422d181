// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/frame_name.hpp"

#include <gtest/gtest.h>

#include "support/recording_host.hpp"

namespace nacelle {
namespace {

TEST(FrameName, has_the_prefix_once) {
  EXPECT_EQ(with_frame_prefix("", "odom"), "odom");
  EXPECT_EQ(with_frame_prefix("", "/odom"), "/odom");
  EXPECT_EQ(with_frame_prefix("r1/", "odom"), "r1/odom");
  EXPECT_EQ(with_frame_prefix("r1/", "r1/odom"), "r1/odom");
  EXPECT_EQ(with_frame_prefix("r1/", "/map"), "map");
  EXPECT_EQ(with_frame_prefix("r1/", ""), "");
}

TEST(FrameName, is_a_parameter_with_the_prefix_that_its_node_was_given) {
  test::RecordingContext context;
  NodeOptions options{context};
  options.append_parameter_override("frame_prefix", std::string{"r1/"});
  Node node{"lidar", options};
  declare_frame_prefix(node);
  node.declare_parameter("frame_id", "lidar_link");

  EXPECT_EQ(frame_name(node, "frame_id"), "r1/lidar_link");
  EXPECT_EQ(node.get<std::string>("frame_id"), "lidar_link");
  EXPECT_FALSE(node.set_parameter({"frame_prefix", std::string{"r2/"}}).successful);
}

}  // namespace
}  // namespace nacelle
