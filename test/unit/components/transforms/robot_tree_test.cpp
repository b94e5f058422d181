// SPDX-License-Identifier: Apache-2.0
#include "transforms/model/robot_tree.hpp"
#include "support/places.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

namespace nacelle::transforms {
namespace {

std::string robot(const std::string& body) { return "<robot name=\"r\">" + body + "</robot>"; }
std::string links(std::initializer_list<const char*> names) {
  std::string all;
  for (const char* name : names) all += std::string{"<link name=\""} + name + "\"/>";
  return all;
}
std::string joint(const char* name, const char* type, const char* parent, const char* child, const char* rest = "") {
  return std::string{"<joint name=\""} + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + rest + "</joint>";
}
const Joint& joint_named(const RobotTree& tree, const std::string& name) {
  return *std::find_if(tree.joints.begin(), tree.joints.end(), [&](const Joint& j) { return j.name == name; });
}

TEST(ReadUrdf, gives_origins_axes_and_kinds) {
  const auto tree =
      read_urdf(robot(links({"a", "b", "c", "d"}) +
                      joint("fixed", "fixed", "a", "b", "<origin xyz=\"1 2 3\" rpy=\"0 0 1.5707963267948966\"/>") +
                      joint("wheel", "continuous", "a", "c", "<axis xyz=\"0 2 0\"/>") +
                      joint("rail", "prismatic", "a", "d",
                            "<axis xyz=\"1 0 0\"/><limit effort=\"1\" velocity=\"1\" lower=\"0\" upper=\"1\"/>")),
                "test");
  ASSERT_TRUE(tree) << tree.error().text();
  EXPECT_EQ(tree->root, "a");
  EXPECT_EQ(tree->joints.size(), 3U);
  const Joint& fixed = joint_named(*tree, "fixed");
  EXPECT_EQ(fixed.kind, JointKind::Fixed);
  EXPECT_NEAR(spatial::yaw_from_quaternion(fixed.origin.rotation), spatial::kPi / 2, 1e-9);
  EXPECT_EQ(fixed.origin.translation_m, (Eigen::Vector3d{1, 2, 3}));
  EXPECT_NEAR(joint_named(*tree, "wheel").axis.y(), 1.0, 1e-12) << "made a unit vector";
  EXPECT_EQ(joint_named(*tree, "rail").kind, JointKind::Sliding);
}

TEST(JointAt, turns_about_and_slides_along_its_own_axis) {
  Joint turning{"t",
                "a",
                "b",
                JointKind::Turning,
                {spatial::quaternion_from_yaw(spatial::kPi / 2), {1, 0, 0}},
                Eigen::Vector3d::UnitZ(),
                {}};
  EXPECT_NEAR(spatial::yaw_from_quaternion(turning.at(0.3).rotation), spatial::kPi / 2 + 0.3, 1e-12);
  EXPECT_EQ(turning.at(0.3).translation_m, turning.origin.translation_m);
  Joint sliding = turning;
  sliding.kind = JointKind::Sliding;
  sliding.axis = Eigen::Vector3d::UnitX();
  EXPECT_LT((sliding.at(0.5).translation_m - Eigen::Vector3d{1, 0.5, 0}).norm(), 1e-12) << "its x is the parent's y";
}

TEST(ReadUrdf, floating_joints_are_left_out_by_name) {
  const auto tree = read_urdf(robot(links({"a", "b"}) + joint("free", "floating", "a", "b")), "test");
  ASSERT_TRUE(tree);
  EXPECT_TRUE(tree->joints.empty());
  EXPECT_EQ(tree->left_out, std::vector<std::string>{"free"});
}

struct Broken {
  const char* name;
  std::string text;
  const char* words;
};
class BrokenUrdf : public ::testing::TestWithParam<Broken> {};
TEST_P(BrokenUrdf, is_refused_with_the_file_and_a_reason) {
  const auto tree = read_urdf(GetParam().text, "/robots/broken.urdf");
  ASSERT_FALSE(tree) << GetParam().name;
  const std::string text = tree.error().text();
  EXPECT_NE(text.find("/robots/broken.urdf"), std::string::npos) << text;
  EXPECT_NE(text.find(GetParam().words), std::string::npos) << text;
  EXPECT_FALSE(tree.error().way_out.empty());
}
INSTANTIATE_TEST_SUITE_P(
    Each, BrokenUrdf,
    ::testing::Values(Broken{"empty", "", "empty"}, Broken{"text", "not xml at all", "this is not XML"},
                      Broken{"unclosed", "<robot name=\"r\">\n<link name=\"a\">",
                             "/robots/broken.urdf:2: the element <link> that begins here is not closed"},
                      Broken{"no links", robot(""), "link"},
                      Broken{"unknown parent", robot(links({"a"}) + joint("j", "fixed", "ghost", "a")), "ghost"},
                      Broken{"two roots", robot(links({"a", "b"})), "root"},
                      Broken{"mimics an unknown joint",
                             robot(links({"a", "b"}) +
                                   joint("j", "continuous", "a", "b", "<axis xyz=\"0 0 1\"/><mimic joint=\"ghost\"/>")),
                             "ghost"},
                      Broken{"mimic loop",
                             robot(links({"a", "b", "c"}) +
                                   joint("j", "continuous", "a", "b", "<axis xyz=\"0 0 1\"/><mimic joint=\"k\"/>") +
                                   joint("k", "continuous", "b", "c", "<axis xyz=\"0 0 1\"/><mimic joint=\"j\"/>")),
                             "mimics itself"},
                      Broken{"no axis",
                             robot(links({"a", "b"}) + joint("j", "continuous", "a", "b", "<axis xyz=\"0 0 0\"/>")),
                             "axis"}));

TEST(DefaultRobot, has_the_frames_and_the_measures_of_the_launch_file) {
  const std::string file = test::source("launch/robot.urdf");
  std::ifstream in{file};
  std::stringstream text;
  text << in.rdbuf();
  const auto tree = read_urdf(text.str(), file);
  ASSERT_TRUE(tree) << tree.error().text();
  EXPECT_EQ(tree->root, "base_footprint");
  const auto place = [&](const char* name) { return joint_named(*tree, name).origin.translation_m; };
  EXPECT_EQ(place("base_joint"), (Eigen::Vector3d{0, 0, 0.033}));
  EXPECT_EQ(place("camera_joint"), (Eigen::Vector3d{0.15, 0, 0.06}));
  EXPECT_EQ(place("lidar_joint"), (Eigen::Vector3d{0, 0, 0.10}));
  EXPECT_EQ(place("imu_joint"), (Eigen::Vector3d{0, 0, 0.04}));
  EXPECT_EQ(place("left_wheel_joint") - place("right_wheel_joint"), (Eigen::Vector3d{0, 0.30, 0}));
  EXPECT_EQ(joint_named(*tree, "left_wheel_joint").axis, Eigen::Vector3d::UnitY());
  // The optical frame: its z looks along the camera's x, its x along the camera's -y.
  const Eigen::Quaterniond optical = joint_named(*tree, "camera_optical_joint").origin.rotation;
  EXPECT_LT((optical * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LT((optical * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitY()).norm(), 1e-12);
}

}  // namespace
}  // namespace nacelle::transforms
