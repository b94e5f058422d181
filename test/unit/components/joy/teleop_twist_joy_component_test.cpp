// SPDX-License-Identifier: Apache-2.0
#include "joy/component/teleop_twist_joy_component.hpp"

#include <gtest/gtest.h>

#include "support/recording_host.hpp"

namespace nacelle::joy {
namespace {

using geometry_msgs::msg::Twist;
using geometry_msgs::msg::TwistStamped;
using sensor_msgs::msg::Joy;

struct TeleopRig {
  explicit TeleopRig(std::map<std::string, ParameterValue> overrides = {}) {
    overrides.insert({{"enable_button", std::int64_t{0}},
                      {"axis_linear.x", std::int64_t{1}},
                      {"axis_angular.yaw", std::int64_t{0}}});
    NodeOptions options{context};
    options.parameter_overrides(std::move(overrides));
    teleop = std::make_unique<TeleopTwistJoyComponent>(options);
    EXPECT_TRUE(teleop->trigger(Transition::Configure).success);
    EXPECT_TRUE(teleop->trigger(Transition::Activate).success);
  }
  void joy(std::vector<float> axes, std::vector<std::int32_t> buttons) {
    Joy message;
    message.axes.assign(axes.begin(), axes.end());
    message.buttons.assign(buttons.begin(), buttons.end());
    context.inject("/joy", message);
  }
  std::vector<Twist> twists() { return context.published<Twist>("/cmd_vel"); }

  test::RecordingContext context;
  std::unique_ptr<TeleopTwistJoyComponent> teleop;
};

TEST(TeleopTwistJoy, publishes_while_the_button_is_held_and_one_zero_after_it) {
  TeleopRig rig;
  rig.joy({0.5F, 1.0F}, {1});
  rig.joy({0.5F, 1.0F}, {1});
  rig.joy({0.5F, 1.0F}, {0});
  rig.joy({0.5F, 1.0F}, {0});
  const auto twists = rig.twists();
  ASSERT_EQ(twists.size(), 3U);
  EXPECT_EQ(twists[0].linear.x, 0.5);
  EXPECT_EQ(twists[0].angular.z, 0.25);
  EXPECT_EQ(twists[1], twists[0]);
  EXPECT_EQ(twists[2], Twist{});
}

TEST(TeleopTwistJoy, has_the_parameters_of_ros) {
  TeleopRig rig{{{"enable_turbo_button", std::int64_t{1}},
                 {"scale_linear_turbo.x", 3.0},
                 {"axis_linear.y", std::int64_t{2}},
                 {"scale_linear.y", 0.25},
                 {"axis_angular.pitch", std::int64_t{2}},
                 {"scale_angular.pitch", 2.0}}};
  rig.joy({0.0F, 1.0F, 1.0F}, {1, 0});
  rig.joy({0.0F, 1.0F, 1.0F}, {0, 1});
  ASSERT_EQ(rig.twists().size(), 2U);
  EXPECT_EQ(rig.twists()[0].linear.y, 0.25);
  EXPECT_EQ(rig.twists()[0].angular.y, 2.0);
  EXPECT_EQ(rig.twists()[1].linear.x, 3.0);
}

TEST(TeleopTwistJoy, may_publish_twists_with_a_stamp) {
  TeleopRig rig{{{"publish_stamped_twist", true}, {"frame", std::string{"base_link"}}}};
  rig.joy({0.0F, 1.0F}, {1});
  const auto twists = rig.context.published<TwistStamped>("/cmd_vel");
  ASSERT_EQ(twists.size(), 1U);
  EXPECT_EQ(twists[0].header.frame_id, "base_link");
  EXPECT_EQ(time_of(twists[0].header.stamp), rig.context.clock().wall_now());
  EXPECT_EQ(twists[0].twist.linear.x, 0.5);
}

TEST(TeleopTwistJoy, obeys_parameters_that_change) {
  TeleopRig rig;
  ASSERT_TRUE(rig.teleop->set_parameter({"scale_linear.x", 0.1}).successful);
  rig.joy({0.0F, 1.0F}, {1});
  EXPECT_EQ(rig.twists().back().linear.x, 0.1);
}

TEST(TeleopTwistJoy, stops_when_it_is_deactivated) {
  TeleopRig rig;
  rig.joy({0.0F, 1.0F}, {1});
  ASSERT_TRUE(rig.teleop->trigger(Transition::Deactivate).success);
  ASSERT_EQ(rig.twists().size(), 2U);
  EXPECT_EQ(rig.twists().back(), Twist{});
}

TEST(TeleopTwistJoy, a_message_without_buttons_stops) {
  TeleopRig rig;
  rig.joy({0.0F, 1.0F}, {1});
  rig.joy({}, {});
  EXPECT_EQ(rig.twists().back(), Twist{});
}

}  // namespace
}  // namespace nacelle::joy
