// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/controller_services.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <controller_manager_msgs/srv/cleanup_controller.hpp>
#include <controller_manager_msgs/srv/configure_controller.hpp>
#include <controller_manager_msgs/srv/list_controller_types.hpp>
#include <controller_manager_msgs/srv/load_controller.hpp>
#include <controller_manager_msgs/srv/reload_controller_libraries.hpp>
#include <controller_manager_msgs/srv/unload_controller.hpp>
#include <thread>

#include "../port/base_rig.hpp"
#include "diff_drive/component/diff_drive_component.hpp"
#include "support/recording_host.hpp"

namespace nacelle::diff_drive {
namespace {

namespace srv = controller_manager_msgs::srv;
using geometry_msgs::msg::Twist;
using sensor_msgs::msg::JointState;
using ::testing::HasSubstr;
using Names = std::vector<std::string>;

const std::string kDrive = "diff_drive_controller";
const std::string kJoints = "joint_state_broadcaster";
constexpr const char* kStopOfWheels = "{\"T\":1,\"L\":0,\"R\":0}";

Twist forward(double linear_mps) {
  Twist message;
  message.linear.x = linear_mps;
  return message;
}

/// A base with its controller_manager, asked as `ros2 control` asks it; behind a real pty with a tiny board, in real time.
class ControllerManagerTest : public ::testing::Test {
 protected:
  NodeOptions options(const std::string& hardware) {
    NodeOptions options{context_};
    options.append_parameter_override("hardware", hardware);
    options.append_parameter_override("serial_port", pty_->path());
    options.append_parameter_override("port_timeout", 0.0);  // the tiny board speaks when a test says so
    options.append_parameter_override("motor_watchdog", 0.0);
    options.append_parameter_override("device_lost", std::string("fault"));
    options.append_parameter_override("cmd_vel_timeout", 60.0);  // a busy machine must not look like a dead sender
    options.append_parameter_override("rearm", std::string("fresh"));
    options.append_parameter_override("controller_manager", true);
    return options;
  }
  static void activate(DiffDriveComponent& drive) {
    ASSERT_TRUE(drive.trigger(Transition::Configure).success);
    ASSERT_TRUE(drive.trigger(Transition::Activate).success);
  }
  template <typename S>
  typename S::Response ask(const std::string& verb, typename S::Request request = {}) {
    typename S::Response response;
    EXPECT_TRUE(context_.call<S>("/controller_manager/" + verb, request, response)) << verb;
    return response;
  }
  template <typename S>
  bool change(const std::string& verb, const std::string& name) {
    typename S::Request request;
    request.name = name;
    return ask<S>(verb, request).ok;
  }
  srv::SwitchController::Response switch_to(Names activate, Names deactivate,
                                            std::int32_t strictness = srv::SwitchController::Request::STRICT) {
    srv::SwitchController::Request request;
    request.activate_controllers = std::move(activate);
    request.deactivate_controllers = std::move(deactivate);
    request.strictness = strictness;
    request.timeout.sec = 30;  // a busy machine
    return ask<srv::SwitchController>("switch_controller", request);
  }
  /// "unloaded" where it is not listed.
  std::string state_of(const std::string& name) {
    const auto all = ask<srv::ListControllers>("list_controllers").controller;
    const auto found = std::ranges::find_if(all, [&](const auto& controller) { return controller.name == name; });
    return found == all.end() ? "unloaded" : found->state;
  }
  bool board_is_told(double left_mps) {
    for (int lines = 0; lines < 500; ++lines) {
      if (!board_.take_until(1)) return false;
      if (std::abs(board_.left_mps - left_mps) < 1e-4) return true;
    }
    return false;
  }
  /// The board gets nothing but stops in the next cycles.
  void expect_stillness() {
    for (int i = 0; i < 10; ++i) {
      ASSERT_TRUE(board_.take_until(1));
      EXPECT_EQ(board_.left_mps, 0.0);
      EXPECT_EQ(board_.right_mps, 0.0);
    }
  }

  SystemClock clock_;
  test::RecordingContext context_{clock_};
  std::unique_ptr<io::PtyPair> pty_ = io::PtyPair::create().value();
  TinyBoard board_{*pty_};
};

TEST_F(ControllerManagerTest, is_there_only_on_request_and_in_the_namespace_of_the_base) {
  srv::ListControllers::Response response;
  {
    const DiffDriveComponent plain{
        NodeOptions{context_}.append_parameter_override("hardware", std::string("loopback"))};
    EXPECT_FALSE(context_.call<srv::ListControllers>("/controller_manager/list_controllers", {}, response));
  }
  auto named = options("loopback");
  named.node_namespace("/robot1").node_name("base");
  const DiffDriveComponent drive{named};
  EXPECT_TRUE(context_.call<srv::ListControllers>("/robot1/controller_manager/list_controllers", {}, response));
}

TEST_F(ControllerManagerTest, lists_the_controllers_in_the_state_of_the_base) {
  auto given = options("loopback");
  given.append_parameter_override("left_wheel_names", Names{"front_left", "rear_left"});
  given.append_parameter_override("right_wheel_names", Names{"front_right", "rear_right"});
  given.append_parameter_override("update_rate", 100.0);
  DiffDriveComponent drive{given};
  const Names commands{"front_left/velocity", "rear_left/velocity", "front_right/velocity", "rear_right/velocity"};
  const Names positions{"front_left/position", "rear_left/position", "front_right/position", "rear_right/position"};

  for (const auto& controller : ask<srv::ListControllers>("list_controllers").controller) {
    EXPECT_EQ(controller.state, "unconfigured");
    EXPECT_TRUE(controller.required_state_interfaces.empty());
  }
  ASSERT_TRUE(drive.trigger(Transition::Configure).success);
  auto all = ask<srv::ListControllers>("list_controllers").controller;
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].name, kDrive);
  EXPECT_EQ(all[0].type, "diff_drive_controller/DiffDriveController");
  EXPECT_EQ(all[0].state, "inactive");
  EXPECT_EQ(all[0].update_rate, 100);
  EXPECT_EQ(all[0].required_command_interfaces, commands);
  EXPECT_EQ(all[0].required_state_interfaces, positions);
  EXPECT_TRUE(all[0].claimed_interfaces.empty());

  ASSERT_TRUE(drive.trigger(Transition::Activate).success);
  all = ask<srv::ListControllers>("list_controllers").controller;
  EXPECT_EQ(all[0].state, "active");
  EXPECT_EQ(all[0].claimed_interfaces, commands);
  EXPECT_EQ(all[1].name, kJoints);
  EXPECT_EQ(all[1].type, "joint_state_broadcaster/JointStateBroadcaster");
  EXPECT_EQ(all[1].state, "active");
  EXPECT_TRUE(all[1].claimed_interfaces.empty());
  EXPECT_EQ(all[1].required_state_interfaces.size(), 8U);

  ASSERT_TRUE(drive.trigger(Transition::Deactivate).success);
  EXPECT_EQ(state_of(kDrive), "inactive");
  ASSERT_TRUE(drive.trigger(Transition::Cleanup).success);
  EXPECT_EQ(state_of(kDrive), "unconfigured");
}

TEST_F(ControllerManagerTest, lists_types_hardware_and_interfaces) {
  DiffDriveComponent drive{options("loopback")};
  const auto types = ask<srv::ListControllerTypes>("list_controller_types");
  EXPECT_EQ(types.types,
            (Names{"diff_drive_controller/DiffDriveController", "joint_state_broadcaster/JointStateBroadcaster"}));
  EXPECT_EQ(types.base_classes.size(), types.types.size());
  for (const auto& interface : ask<srv::ListHardwareInterfaces>("list_hardware_interfaces").command_interfaces)
    EXPECT_FALSE(interface.is_available);

  activate(drive);
  const auto interfaces = ask<srv::ListHardwareInterfaces>("list_hardware_interfaces");
  ASSERT_EQ(interfaces.command_interfaces.size(), 2U);
  EXPECT_EQ(interfaces.command_interfaces[0].name, "left_wheel_joint/velocity");
  EXPECT_EQ(interfaces.command_interfaces[0].data_type, "double");
  EXPECT_TRUE(interfaces.command_interfaces[0].is_available);
  EXPECT_TRUE(interfaces.command_interfaces[0].is_claimed);
  ASSERT_EQ(interfaces.state_interfaces.size(), 4U);
  EXPECT_EQ(interfaces.state_interfaces[1].name, "right_wheel_joint/position");
  EXPECT_EQ(interfaces.state_interfaces[3].name, "right_wheel_joint/velocity");
  EXPECT_FALSE(interfaces.state_interfaces[3].is_claimed);

  const auto components = ask<srv::ListHardwareComponents>("list_hardware_components").component;
  ASSERT_EQ(components.size(), 1U);
  EXPECT_EQ(components[0].name, "diff_drive");
  EXPECT_EQ(components[0].type, "system");
  EXPECT_EQ(components[0].plugin_name, "nacelle_diff_drive/loopback");
  EXPECT_EQ(components[0].state.id, 3);
  EXPECT_EQ(components[0].state.label, "active");
  EXPECT_EQ(components[0].rw_rate, 50);
  EXPECT_EQ(components[0].command_interfaces, interfaces.command_interfaces);
  EXPECT_EQ(components[0].state_interfaces, interfaces.state_interfaces);
}

TEST_F(ControllerManagerTest, a_deactivated_drive_stops_at_once_refuses_commands_and_says_so) {
  DiffDriveComponent drive{options("waveshare")};
  activate(drive);
  context_.inject("/cmd_vel", forward(0.2));
  ASSERT_TRUE(board_is_told(0.2));

  const auto switched = switch_to({}, {kDrive});
  EXPECT_TRUE(switched.ok) << switched.message;
  EXPECT_EQ(state_of(kDrive), "inactive");
  EXPECT_EQ(state_of(kJoints), "active");
  board_.take_all();
  EXPECT_EQ(board_.lines.back(), kStopOfWheels) << "it stood before the answer";
  context_.inject("/cmd_vel", forward(0.3));
  expect_stillness();
  EXPECT_EQ(drive.command_stats().refused[static_cast<std::size_t>(CommandFault::Inactive)], 1U);
  EXPECT_FALSE(ask<srv::ListHardwareInterfaces>("list_hardware_interfaces").command_interfaces[0].is_claimed);
  EXPECT_EQ(drive.get_current_state().state(), StateId::Active);

  board_.say(0.0);
  EXPECT_TRUE(context_.wait_for("/joint_states", 1)) << "the wheels' states go on";

  ASSERT_TRUE(switch_to({kDrive}, {}).ok);
  expect_stillness();  // the command from before is not resumed
  context_.inject("/cmd_vel", forward(0.25));
  EXPECT_TRUE(board_is_told(0.25));
}

TEST_F(ControllerManagerTest, a_sender_that_goes_on_as_before_moves_nothing_after_the_activation) {
  auto given = options("waveshare");
  given.append_parameter_override("rearm", std::string("neutral"));
  DiffDriveComponent drive{given};
  activate(drive);
  ASSERT_TRUE(switch_to({}, {kDrive}).ok);
  context_.inject("/cmd_vel", forward(0.2));
  ASSERT_TRUE(switch_to({kDrive}, {}).ok);
  context_.inject("/cmd_vel", forward(0.2));
  expect_stillness();
  EXPECT_EQ(drive.command_stats().accepted, 1U);
}

TEST_F(ControllerManagerTest, a_deactivated_broadcaster_publishes_nothing_and_the_wheels_are_driven) {
  DiffDriveComponent drive{options("loopback")};
  activate(drive);
  ASSERT_TRUE(context_.wait_for("/joint_states", 2));
  ASSERT_TRUE(switch_to({}, {kJoints}).ok);
  const auto before = context_.published<JointState>("/joint_states").size();
  context_.inject("/cmd_vel", forward(0.2));
  // Two switches take two whole cycles of the loop, and the loopback's wheels have a state in each.
  ASSERT_TRUE(switch_to({kDrive}, {kDrive}).ok);
  EXPECT_EQ(context_.published<JointState>("/joint_states").size(), before);
  EXPECT_EQ(drive.command_stats().accepted, 1U);
  EXPECT_EQ(state_of(kDrive), "active");

  ASSERT_TRUE(switch_to({kJoints}, {}).ok);
  EXPECT_TRUE(context_.wait_for("/joint_states", before + 1));
}

TEST_F(ControllerManagerTest, a_restart_of_the_drive_stops_the_wheels) {
  DiffDriveComponent drive{options("waveshare")};
  activate(drive);
  context_.inject("/cmd_vel", forward(0.2));
  ASSERT_TRUE(board_is_told(0.2));
  ASSERT_TRUE(switch_to({kDrive}, {kDrive}).ok);
  board_.take_all();
  EXPECT_EQ(board_.lines.back(), kStopOfWheels);
  expect_stillness();
  context_.inject("/cmd_vel", forward(0.25));
  EXPECT_TRUE(board_is_told(0.25));
}

TEST_F(ControllerManagerTest, strictness_is_all_or_nothing_and_best_effort_does_what_it_can) {
  DiffDriveComponent drive{options("loopback")};
  activate(drive);
  const auto refused = switch_to({}, {kDrive, "arm_controller"});
  EXPECT_FALSE(refused.ok);
  EXPECT_THAT(refused.message, HasSubstr("arm_controller"));
  EXPECT_EQ(state_of(kDrive), "active");

  const auto done = switch_to({}, {kDrive, "arm_controller"}, srv::SwitchController::Request::BEST_EFFORT);
  EXPECT_TRUE(done.ok);
  EXPECT_THAT(done.message, HasSubstr("Deactivated controllers: [ diff_drive_controller ]"));
  EXPECT_EQ(state_of(kDrive), "inactive");

  const auto again = switch_to({}, {kDrive}, 0);  // ros2_control's default is best effort
  EXPECT_TRUE(again.ok);
  EXPECT_THAT(again.message, HasSubstr("no controllers need to be"));
  EXPECT_FALSE(switch_to({}, {kDrive}).ok);
  EXPECT_FALSE(switch_to({kDrive}, {}, 7).ok) << "there is no such strictness";
  EXPECT_TRUE(switch_to({kDrive}, {}, srv::SwitchController::Request::AUTO).ok);
  EXPECT_EQ(state_of(kDrive), "active");
}

TEST_F(ControllerManagerTest, a_switch_whose_time_is_over_says_so_and_leaves_the_wheels_stopped) {
  auto given = options("loopback");
  given.append_parameter_override("update_rate", 1.0);
  DiffDriveComponent drive{given};
  activate(drive);
  srv::SwitchController::Request request;
  request.strictness = srv::SwitchController::Request::STRICT;
  request.timeout.nanosec = 1;
  request.deactivate_controllers = {kDrive};
  const auto stopped = ask<srv::SwitchController>("switch_controller", request);
  EXPECT_FALSE(stopped.ok);
  EXPECT_THAT(stopped.message, HasSubstr("timed out"));
  EXPECT_EQ(state_of(kDrive), "inactive") << "a stop is not taken back";

  request.deactivate_controllers.clear();
  request.activate_controllers = {kDrive};
  EXPECT_FALSE(ask<srv::SwitchController>("switch_controller", request).ok);
  EXPECT_EQ(state_of(kDrive), "inactive");
  request.timeout = {};
  EXPECT_TRUE(ask<srv::SwitchController>("switch_controller", request).ok) << "two cycles are its usual limit";
}

TEST_F(ControllerManagerTest, a_deactivated_drive_stays_so_when_the_base_is_activated_anew) {
  DiffDriveComponent drive{options("waveshare")};
  activate(drive);
  ASSERT_TRUE(switch_to({}, {kDrive}).ok);
  ASSERT_TRUE(drive.trigger(Transition::Deactivate).success);
  const auto refused = switch_to({kDrive}, {});
  EXPECT_FALSE(refused.ok);
  EXPECT_THAT(refused.message, HasSubstr("the base is inactive"));
  ASSERT_TRUE(drive.trigger(Transition::Cleanup).success);
  activate(drive);
  EXPECT_EQ(state_of(kDrive), "inactive");
  context_.inject("/cmd_vel", forward(0.2));
  expect_stillness();
  ASSERT_TRUE(switch_to({kDrive}, {}).ok);
  context_.inject("/cmd_vel", forward(0.25));
  EXPECT_TRUE(board_is_told(0.25));
}

TEST_F(ControllerManagerTest, unload_and_load_go_the_way_of_ros2_control) {
  DiffDriveComponent drive{options("waveshare")};
  activate(drive);
  EXPECT_FALSE(change<srv::UnloadController>("unload_controller", kDrive)) << "it is active";
  ASSERT_TRUE(switch_to({}, {kDrive}).ok);
  EXPECT_TRUE(change<srv::CleanupController>("cleanup_controller", kDrive));
  EXPECT_EQ(state_of(kDrive), "unconfigured");
  EXPECT_TRUE(change<srv::UnloadController>("unload_controller", kDrive));
  EXPECT_EQ(state_of(kDrive), "unloaded");
  context_.inject("/cmd_vel", forward(0.2));
  expect_stillness();

  EXPECT_FALSE(change<srv::LoadController>("load_controller", "arm_controller"));
  EXPECT_TRUE(change<srv::LoadController>("load_controller", kDrive));
  EXPECT_FALSE(change<srv::LoadController>("load_controller", kDrive));
  EXPECT_EQ(state_of(kDrive), "unconfigured");
  EXPECT_TRUE(change<srv::ConfigureController>("configure_controller", kDrive));
  EXPECT_EQ(state_of(kDrive), "inactive");
  expect_stillness();
  EXPECT_TRUE(switch_to({kDrive}, {}).ok);
  context_.inject("/cmd_vel", forward(0.25));
  EXPECT_TRUE(board_is_told(0.25));
  EXPECT_FALSE(ask<srv::ReloadControllerLibraries>("reload_controller_libraries").ok);
}

TEST_F(ControllerManagerTest, the_state_of_the_hardware_is_told_and_not_set) {
  DiffDriveComponent drive{options("loopback")};
  activate(drive);
  srv::SetHardwareComponentState::Request request;
  request.name = "diff_drive";
  request.target_state.id = 3;
  EXPECT_TRUE(ask<srv::SetHardwareComponentState>("set_hardware_component_state", request).ok) << "it is active";
  request.target_state.id = 2;
  const auto refused = ask<srv::SetHardwareComponentState>("set_hardware_component_state", request);
  EXPECT_FALSE(refused.ok);
  EXPECT_EQ(refused.state.id, 3);
  EXPECT_EQ(refused.state.label, "active");
  EXPECT_EQ(drive.get_current_state().state(), StateId::Active);
  request.name = "arm";
  EXPECT_FALSE(ask<srv::SetHardwareComponentState>("set_hardware_component_state", request).ok);
}

TEST_F(ControllerManagerTest, a_lost_board_makes_its_interfaces_unavailable) {
  auto given = options("waveshare");
  given.append_parameter_override("device_lost", std::string("wait"));
  DiffDriveComponent drive{given};
  activate(drive);
  pty_->hang_up();
  const auto limit = std::chrono::steady_clock::now() + 30s;
  const auto is_available = [&] {
    return ask<srv::ListHardwareInterfaces>("list_hardware_interfaces").command_interfaces[0].is_available;
  };
  while (is_available() && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
  EXPECT_FALSE(is_available());
  EXPECT_TRUE(switch_to({}, {kDrive}).ok) << "what is lost is stopped";
}

TEST_F(ControllerManagerTest, a_hundred_switches_while_driving_end_as_the_last_one_says) {
  auto given = options("waveshare");
  given.append_parameter_override("update_rate", 500.0);
  DiffDriveComponent drive{given};
  activate(drive);
  for (int i = 0; i < 50; ++i) {
    context_.inject("/cmd_vel", forward(0.2));
    ASSERT_TRUE(board_is_told(0.2)) << i;
    ASSERT_TRUE(switch_to({}, {kDrive, kJoints}).ok) << i;
    board_.take_all();
    ASSERT_EQ(board_.lines.back(), kStopOfWheels) << i;
    board_.lines.clear();
    ASSERT_TRUE(switch_to({kDrive, kJoints}, {}).ok) << i;
  }
  EXPECT_EQ(state_of(kDrive), "active");
  EXPECT_EQ(state_of(kJoints), "active");
  EXPECT_TRUE(context_.faults().empty());
}

// As in a container, where the services' node has callbacks while a transition of the base takes its time.
TEST_F(ControllerManagerTest, switches_beside_transitions_of_the_base_end_as_the_last_one_says) {
  auto given = options("loopback");
  given.append_parameter_override("update_rate", 500.0);
  DiffDriveComponent drive{given};
  activate(drive);
  constexpr auto kBestEffort = srv::SwitchController::Request::BEST_EFFORT;
  std::atomic<bool> ends{false};
  std::atomic<int> rounds{0};
  std::thread orders{[&] {
    while (!ends.load()) {
      static_cast<void>(switch_to({}, {kDrive, kJoints}, kBestEffort));
      static_cast<void>(state_of(kDrive));
      static_cast<void>(switch_to({kDrive, kJoints}, {}, kBestEffort));
      ++rounds;
    }
  }};
  for (int i = 0; i < 50 || rounds.load() < 20; ++i) {
    EXPECT_TRUE(drive.trigger(Transition::Deactivate).success);
    EXPECT_TRUE(drive.trigger(Transition::Cleanup).success);
    EXPECT_TRUE(drive.trigger(Transition::Configure).success);
    EXPECT_TRUE(drive.trigger(Transition::Activate).success);
  }
  ends.store(true);
  orders.join();
  EXPECT_TRUE(switch_to({kDrive, kJoints}, {}, kBestEffort).ok);
  EXPECT_EQ(state_of(kDrive), "active");
  EXPECT_EQ(state_of(kJoints), "active");
  EXPECT_TRUE(context_.faults().empty());
}

}  // namespace
}  // namespace nacelle::diff_drive
