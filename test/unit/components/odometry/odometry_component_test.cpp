// SPDX-License-Identifier: Apache-2.0
#include "odometry/component/odometry_component.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/allocation_guard.hpp"
#include "support/log_lines.hpp"
#include "support/recording_host.hpp"

namespace nacelle::odometry {
namespace {

using nav_msgs::msg::Odometry;
using sensor_msgs::msg::JointState;
using tf2_msgs::msg::TFMessage;

class OdometryNode : public ::testing::Test {
 protected:
  OdometryNode() { options_.append_parameter_override("base_frame_id", std::string{"base_footprint"}); }
  void start() {
    node_ = std::make_unique<OdometryComponent>(options_);
    ASSERT_TRUE(node_->trigger(Transition::Configure).success);
    ASSERT_TRUE(node_->trigger(Transition::Activate).success);
  }
  /// Rolls both sides on by distances, 20 ms later.
  void roll(double left_m, double right_m) {
    left_rad_ += left_m / 0.033;
    right_rad_ += right_m / 0.033;
    context_.advance(20ms);
    ms_ += 20;
    send();
  }
  void send() {
    joints_.header.stamp.sec = static_cast<std::int32_t>(100 + ms_ / 1000);
    joints_.header.stamp.nanosec = static_cast<std::uint32_t>(ms_ % 1000 * 1'000'000);
    joints_.name = {"left_wheel_joint", "right_wheel_joint"};
    joints_.position = {left_rad_, right_rad_};
    context_.inject("/joint_states", joints_);
  }
  test::RecordingContext context_;
  NodeOptions options_{context_};
  std::unique_ptr<OdometryComponent> node_;
  JointState joints_;
  std::int64_t ms_{0};
  double left_rad_{12.0}, right_rad_{-7.0};
};

TEST_F(OdometryNode, publishes_one_message_per_sample_with_its_stamp_and_frames) {
  start();
  send();
  for (int i = 0; i < 50; ++i) roll(0.006, 0.006);

  const auto odometry = context_.published<Odometry>("/odom");
  ASSERT_EQ(odometry.size(), 50U) << "the first sample only starts the differences";
  EXPECT_EQ(odometry.back().header.stamp.sec, 101);
  EXPECT_EQ(odometry.back().header.frame_id, "odom");
  EXPECT_EQ(odometry.back().child_frame_id, "base_footprint");
  EXPECT_NEAR(odometry.back().pose.pose.position.x, 0.3, 1e-9);
  EXPECT_NEAR(odometry.back().twist.twist.linear.x, 0.3, 1e-9);
  EXPECT_NEAR(odometry.back().twist.twist.angular.z, 0.0, 1e-9);
}

TEST_F(OdometryNode, its_covariances_are_never_zero_and_the_poses_grows) {
  start();
  send();
  for (int i = 0; i < 20; ++i) roll(0.006, 0.005);
  const auto odometry = context_.published<Odometry>("/odom");
  for (const std::size_t i : {0U, 7U, 14U, 21U, 28U, 35U}) {
    EXPECT_GT(odometry.back().pose.covariance[i], 0.0) << i;
    EXPECT_GT(odometry.back().twist.covariance[i], 0.0) << i;
  }
  for (const std::size_t i : {0U, 7U, 35U})
    EXPECT_GT(odometry.back().pose.covariance[i], odometry.front().pose.covariance[i]) << i;
  EXPECT_EQ(odometry.back().pose.covariance[5], odometry.back().pose.covariance[30]);
}

TEST_F(OdometryNode, broadcasts_the_transform_while_no_other_node_owns_the_frame) {
  start();
  ASSERT_EQ(context_.frames().size(), 1U);
  EXPECT_EQ(context_.frames()[0].parent, "odom");
  EXPECT_EQ(context_.frames()[0].child, "base_footprint");
  EXPECT_EQ(context_.frames()[0].kind, FrameClaimKind::Fallback);
  send();
  roll(0.01, 0.01);
  EXPECT_EQ(context_.published<TFMessage>("/tf").size(), 1U);

  context_.set_frame_owner("base_footprint", "/ekf");
  for (int i = 0; i < 5; ++i) roll(0.01, 0.01);

  EXPECT_EQ(context_.published<TFMessage>("/tf").size(), 1U);
  EXPECT_EQ(context_.published<Odometry>("/odom").size(), 6U) << "the topic goes on";
}

TEST_F(OdometryNode, does_not_yield_if_the_transform_is_explicitly_enabled) {
  options_.append_parameter_override("enable_odom_tf", true);
  start();
  ASSERT_EQ(context_.frames().size(), 1U);
  EXPECT_EQ(context_.frames()[0].kind, FrameClaimKind::Primary);
}

// Wheels of 5 cm radius, 40 cm apart.
constexpr const char* kRobot = R"(<robot name="r"><link name="base"/>
<link name="l"><collision><geometry><cylinder radius="0.05" length="0.02"/></geometry></collision></link>
<link name="r"><visual><geometry><sphere radius="0.05"/></geometry></visual></link>
<joint name="near" type="continuous"><parent link="base"/><child link="l"/><origin xyz="0 0.2 0"/></joint>
<joint name="far" type="continuous"><parent link="base"/><child link="r"/><origin xyz="0 -0.2 0"/></joint>
<ros2_control name="w" type="system"><hardware><plugin>a/B</plugin></hardware>
<joint name="near"><command_interface name="velocity"/></joint>
<joint name="far"><command_interface name="velocity"/></joint></ros2_control></robot>)";

TEST_F(OdometryNode, has_its_wheels_from_the_description) {
  options_.append_parameter_override("robot_description", std::string{kRobot});
  start();
  EXPECT_EQ(node_->get<std::vector<std::string>>("left_wheel_names"), std::vector<std::string>{"near"});
  EXPECT_EQ(node_->get<std::vector<std::string>>("right_wheel_names"), std::vector<std::string>{"far"});
  EXPECT_DOUBLE_EQ(node_->get<double>("wheel_separation"), 0.4);
  EXPECT_DOUBLE_EQ(node_->get<double>("wheel_radius"), 0.05);
}

TEST_F(OdometryNode, a_parameter_stands_above_the_description) {
  options_.append_parameter_override("robot_description", std::string{kRobot});
  options_.append_parameter_override("wheel_separation", 0.38);
  start();
  EXPECT_DOUBLE_EQ(node_->get<double>("wheel_separation"), 0.38);
  EXPECT_DOUBLE_EQ(node_->get<double>("wheel_radius"), 0.05);
}

TEST_F(OdometryNode, broadcasts_nothing_when_disabled) {
  options_.append_parameter_override("enable_odom_tf", false);
  start();
  send();
  roll(0.01, 0.01);
  EXPECT_TRUE(context_.frames().empty());
  EXPECT_TRUE(context_.published<TFMessage>("/tf").empty());
}

TEST_F(OdometryNode, reset_odom_puts_the_pose_back_to_the_origin) {
  start();
  send();
  for (int i = 0; i < 20; ++i) roll(0.006, 0.007);
  std_srvs::srv::Empty::Response response;
  ASSERT_TRUE(context_.call<std_srvs::srv::Empty>("/reset_odom", {}, response));
  roll(0.01, 0.01);
  const auto odometry = context_.published<Odometry>("/odom");
  EXPECT_NEAR(odometry.back().pose.pose.position.x, 0.01, 1e-9);
  EXPECT_NEAR(odometry.back().pose.pose.orientation.z, 0.0, 1e-9);
  EXPECT_LT(odometry.back().pose.covariance[0], odometry[19].pose.covariance[0]);
}

/// What a base with wheels 0.6 m apart and 66 mm in radius enters (corrected by 1.1, 1.2, 1.3), and how far the robot goes for a
/// turn of one wheel.
struct OdometryBesideABase : ::testing::Test {
  OdometryBesideABase() {
    wheels().lock()->push_back({"/base", "/", {"left_wheel_joint"}, {"right_wheel_joint"}, 0.6, 0.066, 1.1, 1.2, 1.3});
  }
  BaseWheelsList& wheels() {
    return *std::static_pointer_cast<BaseWheelsList>(context_.shared_object(kBaseWheelsName, &make_base_wheels));
  }
  PlanarPose after_a_step_of_the_right_wheel() {
    OdometryComponent node{options_};
    EXPECT_TRUE(node.trigger(Transition::Configure).success);
    EXPECT_TRUE(node.trigger(Transition::Activate).success);
    JointState joints;
    joints.name = {left_, right_};
    for (int i = 0; i < 2; ++i) {
      joints.header.stamp.sec = 100 + i;
      joints.position = {0.0, 1.0 * i};
      context_.inject("/joint_states", joints);
    }
    return node.pose();
  }
  test::RecordingContext context_;
  NodeOptions options_{context_};
  std::string left_ = "left_wheel_joint", right_ = "right_wheel_joint";
};

TEST_F(OdometryBesideABase, takes_its_wheels_from_the_base) {
  EXPECT_NEAR(after_a_step_of_the_right_wheel().yaw_rad, 0.066 * 1.3 / (0.6 * 1.1), 1e-12);
}

TEST_F(OdometryBesideABase, takes_its_wheels_names_from_the_base) {
  left_ = "l", right_ = "r";
  wheels().lock()->front().left_joints = {"l"};
  wheels().lock()->front().right_joints = {"r"};
  EXPECT_NEAR(after_a_step_of_the_right_wheel().yaw_rad, 0.066 * 1.3 / (0.6 * 1.1), 1e-12);
}

TEST_F(OdometryBesideABase, does_not_choose_between_two_bases) {
  left_ = "l", right_ = "r";
  wheels().lock()->front().left_joints = {"l"};
  wheels().lock()->front().right_joints = {"r"};
  wheels().lock()->push_back({"/other_base", "/", {"a"}, {"b"}, 0.5, 0.05});
  EXPECT_EQ(after_a_step_of_the_right_wheel().yaw_rad, 0.0);
}

TEST_F(OdometryBesideABase, corrects_the_bases_wheels_by_multipliers_of_its_own) {
  options_.append_parameter_override("wheel_separation_multiplier", 1.05);
  EXPECT_NEAR(after_a_step_of_the_right_wheel().yaw_rad, 0.066 * 1.3 / (0.6 * 1.05), 1e-12);
  options_.append_parameter_override("left_wheel_radius_multiplier", 0.9);
  EXPECT_NEAR(after_a_step_of_the_right_wheel().yaw_rad, 0.066 * 1.3 / (0.6 * 1.05), 1e-12);
  options_.append_parameter_override("right_wheel_radius_multiplier", 0.95);
  EXPECT_NEAR(after_a_step_of_the_right_wheel().yaw_rad, 0.066 * 0.95 / (0.6 * 1.05), 1e-12);
}

TEST_F(OdometryBesideABase, keeps_what_it_was_given) {
  options_.append_parameter_override("wheel_separation", 0.4);
  EXPECT_NEAR(after_a_step_of_the_right_wheel().yaw_rad, 0.066 * 1.3 / 0.4, 1e-12);
  options_.append_parameter_override("wheel_radius", 0.05);
  EXPECT_NEAR(after_a_step_of_the_right_wheel().yaw_rad, 0.05 / 0.4, 1e-12);
}

TEST_F(OdometryBesideABase, leaves_the_wheels_of_others_alone) {
  options_.append_parameter_override("left_wheel_names", std::vector<std::string>{"left_wheel_joint"});
  wheels().lock()->front().left_joints = {"l"};
  EXPECT_NEAR(after_a_step_of_the_right_wheel().yaw_rad, 0.033 / 0.30, 1e-12);
  wheels().lock()->front().left_joints = {"left_wheel_joint"};
  wheels().lock()->front().name_space = "/other";
  EXPECT_NEAR(after_a_step_of_the_right_wheel().yaw_rad, 0.033 / 0.30, 1e-12);
}

TEST_F(OdometryNode, a_restarted_board_does_not_move_the_robot) {
  start();
  send();
  for (int i = 0; i < 20; ++i) roll(0.006, 0.006);
  left_rad_ = right_rad_ = 0.0;
  roll(0.0, 0.0);
  roll(0.006, 0.006);
  EXPECT_EQ(node_->stats().jumps, 1U);
  EXPECT_NEAR(context_.published<Odometry>("/odom").back().pose.pose.position.x, 21 * 0.006, 1e-9);
}

TEST_F(OdometryNode, what_rolled_while_it_was_inactive_is_not_made_up) {
  start();
  send();
  roll(0.01, 0.01);
  ASSERT_TRUE(node_->trigger(Transition::Deactivate).success);
  left_rad_ += 0.5;
  right_rad_ += 0.5;
  ASSERT_TRUE(node_->trigger(Transition::Activate).success);
  roll(0.01, 0.01);
  roll(0.01, 0.01);
  EXPECT_NEAR(context_.published<Odometry>("/odom").back().pose.pose.position.x, 0.02, 1e-9);
}

TEST_F(OdometryNode, calibration_multipliers_count) {
  options_.append_parameter_override("left_wheel_radius_multiplier", 1.1);
  options_.append_parameter_override("right_wheel_radius_multiplier", 1.1);
  start();
  send();
  roll(0.01, 0.01);
  EXPECT_NEAR(context_.published<Odometry>("/odom").back().pose.pose.position.x, 0.011, 1e-9);
}

TEST_F(OdometryNode, allocates_nothing_per_sample) {
  start();
  send();
  for (int i = 0; i < 30; ++i) roll(0.006, 0.005);
  joints_.position = {left_rad_ + 0.1, right_rad_ + 0.1};
  // The component alone: publishing into the recorder keeps every message, so the test counts only its own allocations.
  JointReader reader{{{"left_wheel_joint"}, {"right_wheel_joint"}, 0.033, 0.033, 40.0}};
  VelocityWindow window{10};
  PlanarPose pose;
  const test::AllocationGuard guard;
  for (int i = 0; i < 100; ++i) {
    joints_.position[0] += 0.1;
    const auto step =
        reader.read(WallTime{Duration{i * 20'000'000LL}}, {joints_.name.data(), 2}, {joints_.position.data(), 2});
    if (!step) continue;
    pose = integrate(pose, step->wheels, 0.3, {});
    window.add(0.5 * (step->wheels.left_m + step->wheels.right_m), 0.0, step->dt_s);
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(reader.stats().steps, 99U);
}

TEST_F(OdometryNode, wheel_speeds_without_positions_are_enough) {
  start();
  joints_.name = {"left_wheel_joint", "right_wheel_joint"};
  const auto turn = [&](double left_mps, double right_mps) {
    context_.advance(20ms);
    ms_ += 20;
    joints_.header.stamp.sec = static_cast<std::int32_t>(100 + ms_ / 1000);
    joints_.header.stamp.nanosec = static_cast<std::uint32_t>(ms_ % 1000 * 1'000'000);
    joints_.velocity = {left_mps / 0.033, right_mps / 0.033};
    context_.inject("/joint_states", joints_);
  };
  for (int i = 0; i <= 50; ++i) turn(0.3, 0.3);

  const auto straight = context_.published<Odometry>("/odom");
  ASSERT_EQ(straight.size(), 50U) << "the first sample only starts the differences";
  EXPECT_NEAR(straight.back().pose.pose.position.x, 0.3, 1e-9);
  EXPECT_NEAR(straight.back().twist.twist.linear.x, 0.3, 1e-9);

  for (int i = 0; i < 50; ++i) turn(-0.06, 0.06);

  const auto turned = context_.published<Odometry>("/odom").back();
  EXPECT_NEAR(turned.twist.twist.angular.z, 0.12 / 0.30, 1e-9);
  EXPECT_NEAR(2.0 * std::atan2(turned.pose.pose.orientation.z, turned.pose.pose.orientation.w), 0.99 * 0.12 / 0.30,
              1e-9)
      << "the first step has the mean of both speeds";
}

// Ten radians are neither one turn nor a power of two of steps: only the parameter gives the length of the circle.
TEST_F(OdometryNode, position_range_names_the_circle_in_which_the_wheels_count) {
  options_.append_parameter_override("position_range", 10.0);
  start();

  for (int i = 0; i <= 200; ++i) {
    left_rad_ = right_rad_ = std::fmod(0.5 * i, 10.0);
    roll(0.0, 0.0);
  }

  EXPECT_NEAR(context_.published<Odometry>("/odom").back().pose.pose.position.x, 100.0 * 0.033, 1e-9);
  EXPECT_EQ(node_->stats().jumps, 0U);
}

TEST_F(OdometryNode, a_position_range_below_zero_is_refused_with_its_value) {
  options_.append_parameter_override("position_range", -1.0);
  OdometryComponent node{options_};
  const auto outcome = node.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_NE(outcome.reason.find("position_range: is -1"), std::string::npos) << outcome.reason;
}

TEST_F(OdometryNode, reports_a_wheel_missing_in_joint_states_once) {
  options_.append_parameter_override("right_wheel_names", std::vector<std::string>{"rear_right"});
  start();
  const test::LogLines lines;
  for (int i = 0; i < 3; ++i) roll(0.006, 0.006);
  EXPECT_EQ(lines.all,
            std::vector<std::string>{
                "a message on /joint_states does not have the joint 'rear_right': without it there is no odometry"});
}

TEST_F(OdometryNode, reports_joint_states_with_fewer_values_than_names) {
  start();
  const test::LogLines lines;
  joints_.name = {"left_wheel_joint", "right_wheel_joint"};
  joints_.position = {1.0};
  context_.inject("/joint_states", joints_);
  ASSERT_EQ(lines.all.size(), 1U);
  EXPECT_NE(lines.all[0].find("2 names, 1 positions and 0 velocities"), std::string::npos) << lines.all[0];
}

struct Wrong {
  const char* parameter;
  ParameterValue value;
  const char* words;
};
class OdometryParameters : public ::testing::TestWithParam<Wrong> {};

TEST_P(OdometryParameters, a_wrong_one_is_named_with_its_value) {
  test::RecordingContext context;
  NodeOptions options{context};
  options.append_parameter_override(GetParam().parameter, GetParam().value);
  OdometryComponent node{options};
  const auto outcome = node.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_NE(outcome.reason.find(GetParam().parameter), std::string::npos) << outcome.reason;
  EXPECT_NE(outcome.reason.find(GetParam().words), std::string::npos) << outcome.reason;
}
INSTANTIATE_TEST_SUITE_P(Each, OdometryParameters,
                         ::testing::Values(Wrong{"wheel_radius", 0.0, "positive"},
                                           Wrong{"wheel_separation", -0.3, "-0.3"},
                                           Wrong{"left_wheel_names", std::vector<std::string>{}, "empty"},
                                           Wrong{"right_wheel_names", std::vector<std::string>{"a", "b"}, "2"},
                                           Wrong{"k_left", -1.0, "-1"},
                                           Wrong{"velocity_rolling_window_size", std::int64_t{0}, "0"},
                                           Wrong{"pose_covariance_diagonal", std::vector<double>{1, 2}, "2 numbers"},
                                           Wrong{"base_frame_id", std::string{"odom"}, "odom"}));

}  // namespace
}  // namespace nacelle::odometry
