// SPDX-License-Identifier: Apache-2.0
// The C++ of the pages, each block where its reader would write it. CMakeLists.txt cuts the blocks out of the pages.
#include <gtest/gtest.h>

#include <example_interfaces/action/fibonacci.hpp>
#include <functional>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/laser_scan.hpp>
#include <std_srvs/srv/set_bool.hpp>

#include "nacelle/node/action_server.hpp"
#include "nacelle/qos/presets.hpp"
#include "nacelle/spatial/transform_buffer.hpp"
#include "support/recording_host.hpp"

namespace nacelle {
namespace {

class Series final : public LifecycleNode {
  using Handle = action::ServerGoalHandle<example_interfaces::action::Fibonacci>;

 public:
  explicit Series(const NodeOptions& options)
      : LifecycleNode("series", options){
#include "actions.inc"
        } std::vector<std::shared_ptr<Handle>> goals_;

 private:
  std::shared_ptr<action::Server<example_interfaces::action::Fibonacci>> server_;
};

TEST(ActionsPage, shows_a_server_that_takes_and_rejects_goals) {
  using SendGoal = example_interfaces::action::Fibonacci::Impl::SendGoalService;
  test::RecordingContext context;
  Series node{NodeOptions{context}};
  node.trigger(Transition::Configure);
  node.trigger(Transition::Activate);

  SendGoal::Request good, bad;
  good.goal.order = 5;
  bad.goal.order = -1;
  bad.goal_id.uuid[0] = 1;
  SendGoal::Response taken, rejected;
  ASSERT_TRUE(context.call<SendGoal>("/series/series/_action/send_goal", good, taken));
  ASSERT_TRUE(context.call<SendGoal>("/series/series/_action/send_goal", bad, rejected));

  EXPECT_TRUE(taken.accepted);
  EXPECT_FALSE(rejected.accepted);
  EXPECT_EQ(node.goals_.size(), 1U);
}

class ObstacleStop final : public LifecycleNode {
 public:
  explicit ObstacleStop(const NodeOptions& options);
  std::unique_ptr<FrameClaim> claim_;
};
Result<void, Problem> read_options(const ObstacleStop&) { return err(Problem{"parameter range", "is too short", ""}); }
#include "check.inc"

TEST(CheckPage, shows_a_constructor_that_declares_everything) {
  test::RecordingContext context;
  const auto faults = std::make_shared<ParameterFaults>();

  const ObstacleStop node{NodeOptions{context}.collect_parameter_faults(faults)};

  EXPECT_EQ(node.frame_uses().size(), 1U);
  EXPECT_EQ(node.device_uses().size(), 1U);
  ASSERT_EQ(context.frames().size(), 1U);
  EXPECT_EQ(context.frames()[0].child, "stop_zone");
  EXPECT_EQ(faults->lock()->size(), 1U);
}

#include "coming_from_rclcpp.inc"

TEST(ComingFromRclcppPage, shows_a_component_that_is_written_as_for_rclcpp) {
  test::RecordingContext context;
  Watcher node{NodeOptions{context}};
  node.trigger(Transition::Configure);
  node.trigger(Transition::Activate);
  std_srvs::srv::SetBool::Request request;
  request.data = true;
  std_srvs::srv::SetBool::Response response;
  ASSERT_TRUE(context.call<std_srvs::srv::SetBool>("/enable", request, response));
  EXPECT_TRUE(response.success);
  EXPECT_EQ(node.set_parameter({"range", -1.0}).reason, "range must be above 0");
  context.inject("/scan", sensor_msgs::msg::LaserScan{});
}

class Looking final : public LifecycleNode {
 public:
  explicit Looking(const NodeOptions& options) : LifecycleNode("looking", options) {}
  bool finds_both(WallTime stamp, WallTime t1, WallTime t2) {
#include "transforms.inc"
    return now && moved;
  }

 private:
  std::shared_ptr<spatial::TransformBuffer> buffer_;
};

TEST(TransformsPage, shows_how_to_look_transforms_up) {
  test::RecordingContext context;
  Looking node{NodeOptions{context}};
  const WallTime now = node.now();
  EXPECT_FALSE(node.finds_both(now, now, now));

  const auto buffer = std::static_pointer_cast<spatial::TransformBuffer>(
      context.shared_object(spatial::kTransformBufferName, &spatial::make_shared_transform_buffer));
  ASSERT_TRUE(buffer->insert("odom", "base_link", now, {}, spatial::Permanence::Static));
  ASSERT_TRUE(buffer->insert("base_link", "laser", now, {}, spatial::Permanence::Static));
  EXPECT_TRUE(node.finds_both(now, now, now));
}

TEST(MessagesPage, shows_a_message_and_its_type) {
#include "messages.inc"
  EXPECT_EQ(image.data.size(), 2 * image.width * 480);
  EXPECT_STREQ(type.name, "sensor_msgs/msg/Image");
}

}  // namespace
}  // namespace nacelle
