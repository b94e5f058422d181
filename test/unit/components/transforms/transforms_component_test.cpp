// SPDX-License-Identifier: Apache-2.0
#include "transforms/component/transforms_component.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "support/places.hpp"
#include "support/recording_host.hpp"

namespace nacelle::transforms {
namespace {

using sensor_msgs::msg::JointState;
using tf2_msgs::msg::TFMessage;

class TransformsNode : public ::testing::Test {
 public:
  void start() {
    node_ = std::make_unique<TransformsComponent>(options_);
    const auto configured = node_->trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    ASSERT_TRUE(node_->trigger(Transition::Activate).success);
    context_.spin();
  }
  void use_default_robot() {
    options_.append_parameter_override("robot_description_file", test::source("launch/robot.urdf"));
  }
  JointState wheels(std::int64_t ms, double left, double right) {
    JointState state;
    state.header.stamp.sec = static_cast<std::int32_t>(ms / 1000);
    state.header.stamp.nanosec = static_cast<std::uint32_t>(ms % 1000 * 1'000'000);
    state.name = {"left_wheel_joint", "right_wheel_joint"};
    state.position = {left, right};
    return state;
  }
  std::string refusal() {
    TransformsComponent node{options_};
    const auto outcome = node.trigger(Transition::Configure);
    EXPECT_FALSE(outcome.success);
    return outcome.reason;
  }
  test::RecordingContext context_;
  NodeOptions options_{context_};
  std::unique_ptr<TransformsComponent> node_;
};

TEST_F(TransformsNode, publishes_the_description_and_the_fixed_joints_once) {
  use_default_robot();
  start();
  const auto description = context_.published<std_msgs::msg::String>("/robot_description");
  ASSERT_EQ(description.size(), 1U);
  EXPECT_NE(description[0].data.find("<robot name=\"nacelle_robot\">"), std::string::npos);
  const auto fixed = context_.published<TFMessage>("/tf_static");
  ASSERT_EQ(fixed.size(), 1U);
  EXPECT_EQ(fixed[0].transforms.size(), 5U) << "base, camera, its optical frame, lidar, imu";
}

TEST_F(TransformsNode, fills_the_shared_buffer_with_its_own_and_with_other_nodes_transforms) {
  use_default_robot();
  start();
  const auto& buffer = *node_->buffer();
  const auto imu = buffer.lookup("base_footprint", "imu_link", WallTime{});
  ASSERT_TRUE(imu) << imu.error().text();
  EXPECT_NEAR(imu->X_TS.translation_m.z(), 0.073, 1e-12);

  TFMessage other;
  auto& odom = other.transforms.emplace_back();
  odom.header.stamp.sec = 5;
  odom.header.frame_id = "odom";
  odom.child_frame_id = "base_footprint";
  odom.transform.translation.x = 2.0;
  odom.transform.rotation.w = 1.0;
  context_.inject("/tf", other);
  const auto lidar = buffer.lookup("odom", "lidar_link", WallTime{5s});
  ASSERT_TRUE(lidar) << lidar.error().text();
  EXPECT_NEAR(lidar->X_TS.translation_m.x(), 2.0, 1e-12);
  EXPECT_EQ(node_->buffer(),
            context_.shared_object(spatial::kTransformBufferName, &spatial::make_shared_transform_buffer));
}

TEST_F(TransformsNode, turns_the_wheels_at_thirty_hertz_with_the_stamp_of_the_joint_state) {
  use_default_robot();
  start();
  for (int i = 0; i < 500; ++i) context_.inject("/joint_states", wheels(100000 + 20 * i, 0.1 * i, -0.1 * i));
  const auto moving = context_.published<TFMessage>("/tf");
  EXPECT_NEAR(static_cast<double>(moving.size()), 300.0, 2.0);
  ASSERT_EQ(moving.front().transforms.size(), 2U);
  EXPECT_EQ(moving.front().transforms[0].child_frame_id, "left_wheel_link");
  EXPECT_EQ(moving.front().transforms[0].header.stamp.sec, 100);
  const auto turned = node_->buffer()->lookup("base_link", "left_wheel_link", WallTime{});
  ASSERT_TRUE(turned) << turned.error().text();
  EXPECT_NEAR(turned->X_TS.translation_m.y(), 0.15, 1e-12);
}

TEST_F(TransformsNode, claims_every_frame_it_broadcasts) {
  use_default_robot();
  start();
  EXPECT_EQ(context_.frames().size(), 7U);
  for (const auto& claim : context_.frames()) {
    const bool wheel = claim.child.find("wheel") != std::string::npos;
    EXPECT_EQ(claim.kind, wheel ? FrameClaimKind::Primary : FrameClaimKind::Fixed) << claim.child;
  }
}

TEST_F(TransformsNode, adds_static_transforms_and_a_prefix) {
  use_default_robot();
  options_.append_parameter_override("frame_prefix", std::string{"r1/"});
  options_.append_parameter_override(
      "static_transforms", std::vector<std::string>{"1 0 0 0 0 0 /map odom", "2 0 0 0 0 0 base_link r1/mast"});
  start();
  EXPECT_TRUE(node_->buffer()->lookup("r1/base_link", "r1/imu_link", WallTime{}));
  EXPECT_NEAR(node_->buffer()->lookup("map", "r1/odom", WallTime{})->X_TS.translation_m.x(), 1.0, 1e-12);
  EXPECT_NEAR(node_->buffer()->lookup("r1/base_link", "r1/mast", WallTime{})->X_TS.translation_m.x(), 2.0, 1e-12);
}

TEST_F(TransformsNode, works_with_static_transforms_alone) {
  options_.append_parameter_override("static_transforms", std::vector<std::string>{"1 0 0 0 0 0 base_link laser"});
  start();
  EXPECT_TRUE(context_.published<std_msgs::msg::String>("/robot_description").empty());
  EXPECT_EQ(context_.published<TFMessage>("/tf_static").size(), 1U);
}

TEST_F(TransformsNode, counts_joint_states_that_it_cannot_use) {
  use_default_robot();
  start();
  auto short_one = wheels(1000, 0, 0);
  short_one.position.resize(1);
  context_.inject("/joint_states", short_one);
  auto unknown = wheels(1000, 0, 0);
  unknown.name[1] = "gripper_joint";
  context_.inject("/joint_states", unknown);
  EXPECT_EQ(node_->stats().mismatched, 1U);
  EXPECT_EQ(node_->stats().unknown_joints, 1U);
}

TEST_F(TransformsNode, a_transform_that_is_none_is_refused_and_does_no_harm) {
  use_default_robot();
  start();
  TFMessage bad;
  auto& self = bad.transforms.emplace_back();
  self.header.frame_id = self.child_frame_id = "base_link";
  self.transform.rotation.w = 1.0;
  auto& zero = bad.transforms.emplace_back();
  zero.header.frame_id = "odom";
  zero.child_frame_id = "base_footprint";
  zero.transform.rotation.w = 0.0;
  context_.inject("/tf", bad);
  EXPECT_EQ(node_->buffer()->stats().self_transform, 1U);
  EXPECT_EQ(node_->buffer()->stats().not_normalised, 1U);
}

TEST_F(TransformsNode, a_clock_that_is_set_back_clears_the_future) {
  use_default_robot();
  start();
  const auto send = [&](double x) {
    TFMessage message;
    auto& odom = message.transforms.emplace_back();
    odom.header.stamp.sec = static_cast<std::int32_t>(context_.clock().wall_now().nanoseconds() / 1'000'000'000);
    odom.header.frame_id = "odom";
    odom.child_frame_id = "base_footprint";
    odom.transform.translation.x = x;
    odom.transform.rotation.w = 1.0;
    context_.inject("/tf", message);
  };
  send(1.0);
  context_.clock().step_wall(-3600s);
  send(2.0);
  const auto latest = node_->buffer()->lookup_latest("odom", "base_link");
  ASSERT_TRUE(latest) << latest.error().text();
  EXPECT_EQ(latest->X_TS.translation_m.x(), 2.0);
  EXPECT_TRUE(node_->buffer()->lookup_latest("base_link", "imu_link")) << "what does not move stays";
}

TEST_F(TransformsNode, says_which_file_is_missing) {
  options_.append_parameter_override("robot_description_file", std::string{"/nowhere/robot.urdf"});
  const auto reason = refusal();
  EXPECT_NE(reason.find("/nowhere/robot.urdf"), std::string::npos) << reason;
  EXPECT_NE(reason.find("No such file"), std::string::npos) << reason;
}

TEST_F(TransformsNode, expands_a_xacro_file) {
  const std::string file = ::testing::TempDir() + "transforms_component_test.xacro";
  std::ofstream(file) << R"xml(<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="height" default="0.1"/>
<link name="base_link"/><link name="mast"/>
<joint name="up" type="fixed"><parent link="base_link"/><child link="mast"/><origin xyz="0 0 ${$(arg height)*2}"/></joint>
</robot>)xml";
  options_.append_parameter_override("robot_description_file", file);
  EXPECT_NE(refusal().find(file + ":4: ${$(arg height)*2}"), std::string::npos);
  std::ofstream(file) << R"xml(<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="height" default="0.1"/><xacro:property name="height" value="$(arg height)"/>
<link name="base_link"/><link name="mast"/>
<joint name="up" type="fixed"><parent link="base_link"/><child link="mast"/><origin xyz="0 0 ${height*2}"/></joint>
</robot>)xml";
  options_.append_parameter_override("xacro_arguments", std::vector<std::string>{"height:=0.5"});
  start();
  const auto mast = node_->buffer()->lookup("base_link", "mast", WallTime{});
  ASSERT_TRUE(mast) << mast.error().text();
  EXPECT_EQ(mast->X_TS.translation_m.z(), 1.0);
  EXPECT_EQ(context_.published<std_msgs::msg::String>("/robot_description")[0].data.find("xacro:"), std::string::npos);
}

TEST_F(TransformsNode, says_that_nothing_is_described) {
  EXPECT_NE(refusal().find("robot_description_file"), std::string::npos);
}

TEST_F(TransformsNode, a_frame_with_two_parents_is_refused) {
  use_default_robot();
  options_.append_parameter_override("static_transforms", std::vector<std::string>{"0 0 0 0 0 0 camera_link imu_link"});
  const auto reason = refusal();
  EXPECT_NE(reason.find("imu_link"), std::string::npos) << reason;
  EXPECT_NE(reason.find("two parents"), std::string::npos) << reason;
}

TEST_F(TransformsNode, a_wrong_static_transform_is_quoted) {
  options_.append_parameter_override("static_transforms", std::vector<std::string>{"0 0 zero 0 0 0 a b"});
  EXPECT_NE(refusal().find("'zero'"), std::string::npos);
}

}  // namespace
}  // namespace nacelle::transforms
