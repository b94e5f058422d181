// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/diff_drive_component.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "../port/base_rig.hpp"
#include "support/recording_host.hpp"

namespace nacelle::diff_drive {
namespace {

using geometry_msgs::msg::Twist;
using geometry_msgs::msg::TwistStamped;
using sensor_msgs::msg::BatteryState;
using sensor_msgs::msg::JointState;
using ::testing::HasSubstr;

constexpr const char* kStopLine = "{\"T\":1,\"L\":0,\"R\":0}";

Twist twist(double linear_mps, double angular_rps = 0.0) {
  Twist message;
  message.linear.x = linear_mps;
  message.angular.z = angular_rps;
  return message;
}

std_msgs::msg::Bool emergency(bool set) {
  std_msgs::msg::Bool message;
  message.data = set;
  return message;
}

/// The component behind a real pty with a tiny board, in real time: its loop is a thread of its own.
class DriveTest : public ::testing::Test {
 protected:
  NodeOptions on_the_board() {
    NodeOptions options{context_};
    options.append_parameter_override("hardware", std::string("waveshare"));
    options.append_parameter_override("serial_port", pty_->path());
    options.append_parameter_override("port_timeout", 0.0);  // the tiny board speaks when a test says so
    options.append_parameter_override("motor_watchdog", 0.0);
    options.append_parameter_override("cmd_vel_timeout", 60.0);  // a busy machine must not look like a dead sender
    options.append_parameter_override("rearm", std::string("fresh"));  // without a minute of silence
    options.append_parameter_override("reopen_timeout", 0.0);
    options.append_parameter_override("device_lost", std::string("fault"));
    return options;
  }
  NodeOptions on_the_loopback() {
    NodeOptions options{context_};
    options.append_parameter_override("hardware", std::string("loopback"));
    return options;
  }
  static void activate(DiffDriveComponent& drive) {
    const auto configured = drive.trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    const auto activated = drive.trigger(Transition::Activate);
    ASSERT_TRUE(activated.success) << activated.reason;
  }
  /// Reads speed commands until this one arrives; false after a few seconds of other commands.
  bool board_is_told(double left_mps, double right_mps) {
    for (int lines = 0; lines < 200; ++lines) {
      if (!board_.take_until(1)) return false;
      if (std::abs(board_.left_mps - left_mps) < 1e-4 && std::abs(board_.right_mps - right_mps) < 1e-4) return true;
    }
    return false;
  }
  /// Everything that is on its way; the wheels' last command then is what the board was left with.
  void drain_board() {
    for (pollfd watched{pty_->device_end(), POLLIN, 0}; ::poll(&watched, 1, 100) > 0;) board_.take_until(1);
  }

  SystemClock clock_;
  test::RecordingContext context_{clock_};
  std::unique_ptr<io::PtyPair> pty_ = io::PtyPair::create().value();
  TinyBoard board_{*pty_};
};

TEST_F(DriveTest, the_constructor_touches_no_hardware) {
  auto options = on_the_board();
  options.append_parameter_override("serial_port", std::string("/nowhere/at/all"));
  const DiffDriveComponent drive{options};
  EXPECT_EQ(drive.get_name(), "diff_drive");
  EXPECT_TRUE(context_.safe_stop().empty());
}

TEST_F(DriveTest, enters_its_wheels_for_odometry_while_it_is_there) {
  const auto list =
      std::static_pointer_cast<BaseWheelsList>(context_.shared_object(kBaseWheelsName, &make_base_wheels));
  {
    auto options = on_the_loopback();
    options.append_parameter_override("wheel_separation", 0.5);
    options.append_parameter_override("wheel_separation_multiplier", 1.1);
    const DiffDriveComponent drive{options};
    ASSERT_EQ(list->lock()->size(), 1U);
    const BaseWheels wheels = list->lock()->front();
    EXPECT_EQ(wheels.node, "/diff_drive");
    EXPECT_EQ(wheels.left_joints, std::vector<std::string>{"left_wheel_joint"});
    EXPECT_EQ(wheels.separation_m, 0.5);
    EXPECT_EQ(wheels.separation_multiplier, 1.1);
  }
  EXPECT_TRUE(list->lock()->empty());
}

TEST_F(DriveTest, a_port_that_does_not_exist_is_named) {
  auto options = on_the_board();
  options.append_parameter_override("serial_port", std::string("/nowhere/at/all"));
  options.append_parameter_override("required_device", true);
  DiffDriveComponent drive{options};
  const auto outcome = drive.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_EQ(outcome.state, StateId::Unconfigured);
  EXPECT_THAT(outcome.reason, HasSubstr("/diff_drive"));
  EXPECT_THAT(outcome.reason, HasSubstr("serial_port"));
  EXPECT_THAT(outcome.reason, HasSubstr("/nowhere/at/all"));
}

TEST_F(DriveTest, a_parameter_out_of_range_is_named) {
  auto options = on_the_loopback();
  options.append_parameter_override("wheel_radius", 0.0);
  DiffDriveComponent drive{options};
  const auto outcome = drive.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_THAT(outcome.reason, HasSubstr("wheel_radius"));
}

TEST_F(DriveTest, publishes_joint_states_with_their_names_at_the_capture_time) {
  DiffDriveComponent drive{on_the_loopback()};
  activate(drive);
  ASSERT_TRUE(context_.wait_for("/joint_states", 5));
  ASSERT_TRUE(drive.trigger(Transition::Deactivate).success);

  const auto states = context_.published<JointState>("/joint_states");
  ASSERT_GE(states.size(), 5U);
  for (const auto& state : states) {
    EXPECT_EQ(state.name, (std::vector<std::string>{"left_wheel_joint", "right_wheel_joint"}));
    EXPECT_EQ(state.position, (Buffer<double>{0.0, 0.0}));
    EXPECT_EQ(state.velocity, (Buffer<double>{0.0, 0.0}));
    EXPECT_TRUE(state.effort.empty());
    EXPECT_GT(state.header.stamp.sec, 1'600'000'000);
  }
}

TEST_F(DriveTest, every_wheel_of_a_side_has_the_sides_position_and_velocity) {
  const std::vector<std::string> left{"front_left", "rear_left"}, right{"front_right", "rear_right"};
  auto options = on_the_loopback();
  options.append_parameter_override("left_wheel_names", left);
  options.append_parameter_override("right_wheel_names", right);
  options.append_parameter_override("cmd_vel_timeout", 60.0);
  options.append_parameter_override("rearm", std::string("fresh"));
  DiffDriveComponent drive{options};
  const auto list =
      std::static_pointer_cast<BaseWheelsList>(context_.shared_object(kBaseWheelsName, &make_base_wheels));
  EXPECT_EQ(list->lock()->front().left_joints, left) << "odometry takes the mean of them";
  EXPECT_EQ(list->lock()->front().right_joints, right);
  activate(drive);
  context_.inject("/cmd_vel", twist(0.2, 1.0));
  std::vector<JointState> states;
  for (std::size_t count = 10; count <= 500 && (states.empty() || states.back().velocity[0] == 0.0); count += 10) {
    ASSERT_TRUE(context_.wait_for("/joint_states", count));
    states = context_.published<JointState>("/joint_states");
  }
  ASSERT_TRUE(drive.trigger(Transition::Deactivate).success);
  EXPECT_NE(states.back().velocity[0], 0.0);
  EXPECT_NE(states.back().velocity[0], states.back().velocity[2]) << "it turns";
  for (const JointState& state : states) {
    ASSERT_EQ(state.name, (std::vector<std::string>{"front_left", "rear_left", "front_right", "rear_right"}));
    ASSERT_EQ(state.position.size(), 4U);
    ASSERT_EQ(state.velocity.size(), 4U);
    EXPECT_EQ(state.position[0], state.position[1]);
    EXPECT_EQ(state.position[2], state.position[3]);
    EXPECT_EQ(state.velocity[0], state.velocity[1]);
    EXPECT_EQ(state.velocity[2], state.velocity[3]);
  }
}

TEST_F(DriveTest, tells_the_battery_with_nan_for_what_is_not_measured) {
  DiffDriveComponent drive{on_the_board()};
  activate(drive);
  board_.say(0.0);
  ASSERT_TRUE(context_.wait_for("/battery/state", 1));
  const auto battery = context_.published<BatteryState>("/battery/state").front();
  EXPECT_FLOAT_EQ(battery.voltage, 12.0F);
  for (const float unmeasured : {battery.temperature, battery.current, battery.charge, battery.capacity,
                                 battery.design_capacity, battery.percentage}) {
    EXPECT_TRUE(std::isnan(unmeasured));
  }
  EXPECT_TRUE(battery.present);
}

TEST_F(DriveTest, follows_twist_and_twist_stamped_on_the_same_topic) {
  DiffDriveComponent drive{on_the_board()};
  activate(drive);
  context_.inject("/cmd_vel", twist(0.2));
  EXPECT_TRUE(board_is_told(0.2, 0.2));

  TwistStamped stamped;
  stamped.twist = twist(0.1, 0.4);
  context_.inject("/cmd_vel", stamped);
  EXPECT_TRUE(board_is_told(0.1 - 0.4 * 0.15, 0.1 + 0.4 * 0.15));
  EXPECT_EQ(drive.command_stats().accepted, 2U);
}

TEST_F(DriveTest, stops_when_the_commands_stop) {
  auto options = on_the_board();
  options.append_parameter_override("cmd_vel_timeout", 0.5);
  DiffDriveComponent drive{options};
  activate(drive);
  context_.inject("/cmd_vel", twist(0.2));
  ASSERT_TRUE(board_is_told(0.2, 0.2));
  EXPECT_TRUE(board_is_told(0.0, 0.0));
}

TEST_F(DriveTest, keeps_the_command_before_a_broken_one) {
  DiffDriveComponent drive{on_the_board()};
  activate(drive);
  context_.inject("/cmd_vel", twist(0.2));
  ASSERT_TRUE(board_is_told(0.2, 0.2));
  context_.inject("/cmd_vel", twist(std::numeric_limits<double>::quiet_NaN()));
  context_.inject("/cmd_vel", twist(1e12));
  ASSERT_TRUE(board_.take_until(1));
  ASSERT_TRUE(board_.take_until(1));
  EXPECT_EQ(board_.left_mps, 0.2);
  EXPECT_EQ(drive.command_stats().refused[static_cast<std::size_t>(CommandFault::NotFinite)], 1U);
  EXPECT_EQ(drive.command_stats().refused[static_cast<std::size_t>(CommandFault::Absurd)], 1U);
}

TEST_F(DriveTest, refuses_a_command_whose_stamp_is_old) {
  DiffDriveComponent drive{on_the_loopback()};
  activate(drive);
  TwistStamped stamped;
  stamped.twist = twist(0.1);
  stamped.header.stamp.sec = static_cast<std::int32_t>(clock_.wall_now().nanoseconds() / 1'000'000'000) - 5;
  context_.inject("/cmd_vel", stamped);
  EXPECT_EQ(drive.command_stats().refused[static_cast<std::size_t>(CommandFault::Stale)], 1U);
  EXPECT_EQ(drive.command_stats().accepted, 0U);
}

TEST_F(DriveTest, leaves_the_board_with_a_stop_and_moves_again_only_on_a_new_command) {
  DiffDriveComponent drive{on_the_board()};
  activate(drive);
  context_.inject("/cmd_vel", twist(0.2));
  ASSERT_TRUE(board_is_told(0.2, 0.2));

  ASSERT_TRUE(drive.trigger(Transition::Deactivate).success);
  context_.inject("/cmd_vel", twist(0.3));  // it is not read
  drain_board();
  EXPECT_EQ(board_.lines.back(), kStopLine);

  ASSERT_TRUE(drive.trigger(Transition::Activate).success);
  board_.lines.clear();
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(board_.take_until(1));
  for (const auto& line : board_.lines) EXPECT_THAT(line, ::testing::Not(HasSubstr("\"L\":0."))) << line;
  context_.inject("/cmd_vel", twist(0.25));
  EXPECT_TRUE(board_is_told(0.25, 0.25));
}

TEST_F(DriveTest, an_unload_while_driving_leaves_the_board_with_a_stop) {
  {
    DiffDriveComponent drive{on_the_board()};
    activate(drive);
    context_.inject("/cmd_vel", twist(0.2));
    ASSERT_TRUE(board_is_told(0.2, 0.2));
  }
  drain_board();
  EXPECT_EQ(board_.lines.back(), kStopLine);
}

TEST_F(DriveTest, registers_the_stop_frame_from_configure_to_cleanup) {
  DiffDriveComponent drive{on_the_board()};
  ASSERT_TRUE(drive.trigger(Transition::Configure).success);
  EXPECT_EQ(as_text(context_.safe_stop()), "\n" + std::string(kStopLine) + "\n") << "it ends a line that was torn";
  ASSERT_TRUE(drive.trigger(Transition::Activate).success);
  ASSERT_TRUE(drive.trigger(Transition::Deactivate).success);
  EXPECT_FALSE(context_.safe_stop().empty());
  ASSERT_TRUE(drive.trigger(Transition::Cleanup).success);
  EXPECT_TRUE(context_.safe_stop().empty());
}

TEST_F(DriveTest, a_lost_line_is_a_fault_that_can_be_configured_again) {
  DiffDriveComponent drive{on_the_board()};
  activate(drive);
  pty_->hang_up();
  const auto limit = std::chrono::steady_clock::now() + 10s;
  while (context_.faults().empty() && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
  ASSERT_EQ(context_.faults().size(), 1U);
  EXPECT_EQ(context_.faults()[0].code, "SERIAL_LOST");
  EXPECT_THAT(context_.faults()[0].text, HasSubstr("cable"));

  drive.process_fault(context_.faults()[0]);
  EXPECT_EQ(drive.get_current_state().state(), StateId::Unconfigured);
  EXPECT_TRUE(context_.safe_stop().empty());

  pty_ = io::PtyPair::create().value();
  drive.set_parameter({"serial_port", pty_->path()});
  EXPECT_TRUE(drive.trigger(Transition::Configure).success);
}

TEST_F(DriveTest, a_silent_board_is_a_fault) {
  auto options = on_the_board();
  options.append_parameter_override("port_timeout", 0.1);
  DiffDriveComponent drive{options};
  activate(drive);
  const auto limit = std::chrono::steady_clock::now() + 10s;
  while (context_.faults().empty() && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
  ASSERT_FALSE(context_.faults().empty());
  EXPECT_EQ(context_.faults()[0].code, "FEEDBACK_LOST");
}

TEST_F(DriveTest, records_how_long_a_command_took_to_the_wheels) {
  DiffDriveComponent drive{on_the_board()};
  activate(drive);
  context_.inject("/cmd_vel", twist(0.2));
  ASSERT_TRUE(board_is_told(0.2, 0.2));
  ASSERT_TRUE(drive.trigger(Transition::Deactivate).success);
  EXPECT_EQ(context_.histogram("command_to_wheel").count(), 1U);
}

TEST_F(DriveTest, the_limited_velocity_is_published_on_request_and_keeps_the_curve) {
  auto options = on_the_loopback();
  options.append_parameter_override("rearm", std::string("fresh"));
  options.append_parameter_override("publish_limited_velocity", true);
  options.append_parameter_override("linear.x.max_velocity", 0.25);
  options.append_parameter_override("linear.x.max_acceleration", 1.0);
  DiffDriveComponent drive{options};
  activate(drive);
  // A control loop that a busy machine keeps from running for too long forgets its command, so the command is repeated.
  std::vector<TwistStamped> twists;
  const auto is_at_its_limit = [](const TwistStamped& limited) {
    return std::abs(limited.twist.linear.x - 0.25) < 1e-9;
  };
  for (std::size_t count = 20; count < 2000 && std::ranges::none_of(twists, is_at_its_limit); count += 20) {
    context_.inject("/cmd_vel", twist(1.0, 2.0));
    ASSERT_TRUE(context_.wait_for("/diff_drive/cmd_vel_out", count));
    twists = context_.published<TwistStamped>("/diff_drive/cmd_vel_out");
  }
  EXPECT_TRUE(std::ranges::any_of(twists, is_at_its_limit));
  for (const auto& limited : twists) {
    EXPECT_LE(limited.twist.linear.x, 0.25 + 1e-9);
    EXPECT_NEAR(limited.twist.angular.z, 2.0 * limited.twist.linear.x, 1e-9);
  }
}

TEST_F(DriveTest, use_stamped_vel_chooses_the_type_that_its_inputs_announce_without_a_publisher) {
  using geometry_msgs::msg::Twist;
  using geometry_msgs::msg::TwistStamped;
  for (const bool stamped : {true, false}) {
    test::RecordingContext context;
    const DiffDriveComponent drive{NodeOptions{context}.append_parameter_override("use_stamped_vel", stamped)};
    for (const auto& [type, announced] : context.announced("/cmd_vel")) {
      const bool is_default = type == (stamped ? TwistStamped::message_type() : Twist::message_type()).name;
      EXPECT_EQ(announced, is_default ? Announced::ByDefault : Announced::WithItsPublisher) << type;
    }
    EXPECT_EQ(context.announced("/cmd_vel").size(), 2U);
  }
}

TEST_F(DriveTest, an_emergency_stop_stops_the_board_and_a_release_alone_moves_nothing) {
  DiffDriveComponent drive{on_the_board()};
  activate(drive);
  context_.inject("/cmd_vel", twist(0.2));
  ASSERT_TRUE(board_is_told(0.2, 0.2));
  context_.inject("/emergency_stop", emergency(true));
  ASSERT_TRUE(board_is_told(0.0, 0.0));
  context_.inject("/cmd_vel", twist(0.2));
  context_.inject("/emergency_stop", emergency(false));
  board_.lines.clear();
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(board_.take_until(1));
  for (const auto& line : board_.lines) EXPECT_EQ(line, kStopLine);
  context_.inject("/cmd_vel", twist(0.25));
  EXPECT_TRUE(board_is_told(0.25, 0.25));
}

TEST_F(DriveTest, an_emergency_stop_is_obeyed_whatever_its_qos_and_only_a_latched_publisher_releases_it) {
  DiffDriveComponent drive{on_the_board()};
  activate(drive);
  Node anybody{"anybody", NodeOptions{context_}};
  for (const QoS& qos : {QoS(10), QoS(10).best_effort(), QoS(1).best_effort().transient_local()}) {
    context_.inject("/cmd_vel", twist(0.2));
    ASSERT_TRUE(board_is_told(0.2, 0.2));
    const auto careless = anybody.create_publisher<std_msgs::msg::Bool>("emergency_stop", qos);
    careless->publish(emergency(true));
    context_.spin();
    ASSERT_TRUE(board_is_told(0.0, 0.0));
    careless->publish(emergency(false));
    context_.spin();
    context_.inject("/cmd_vel", twist(0.2));
    board_.lines.clear();
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(board_.take_until(1));
    for (const auto& line : board_.lines) EXPECT_EQ(line, kStopLine);
    context_.inject("/emergency_stop", emergency(false));
  }
  context_.inject("/cmd_vel", twist(0.25));
  EXPECT_TRUE(board_is_told(0.25, 0.25));
}

TEST_F(DriveTest, an_emergency_stop_from_before_the_activation_holds) {
  DiffDriveComponent drive{on_the_board()};
  ASSERT_TRUE(drive.trigger(Transition::Configure).success);
  context_.inject("/emergency_stop", emergency(true));
  ASSERT_TRUE(drive.trigger(Transition::Activate).success);
  context_.spin();
  context_.inject("/cmd_vel", twist(0.2));
  board_.lines.clear();
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(board_.take_until(1));
  for (const auto& line : board_.lines) EXPECT_THAT(line, ::testing::Not(HasSubstr("\"L\":0."))) << line;
}

TEST_F(DriveTest, a_required_emergency_stop_that_is_not_there_holds_the_wheels) {
  auto options = on_the_board();
  options.append_parameter_override("emergency_stop_required", true);
  DiffDriveComponent drive{options};
  activate(drive);
  context_.inject("/emergency_stop", emergency(false));  // from a publisher without liveliness
  context_.inject("/cmd_vel", twist(0.2));
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(board_.take_until(1));
  for (const auto& line : board_.lines) EXPECT_THAT(line, ::testing::Not(HasSubstr("\"L\":0."))) << line;
  const auto promised = QoS(KeepAll{})
                            .reliable()
                            .transient_local()
                            .liveliness(Liveliness::ManualByTopic)
                            .liveliness_lease_duration(500ms);
  Node guard{"guard", NodeOptions{context_}};
  auto publisher = guard.create_publisher<std_msgs::msg::Bool>("emergency_stop", promised);
  context_.inject("/cmd_vel", twist(0.25));
  EXPECT_TRUE(board_is_told(0.25, 0.25));
  publisher.reset();
  EXPECT_TRUE(board_is_told(0.0, 0.0));
}

TEST_F(DriveTest, the_topic_of_the_highest_priority_commands) {
  auto options = on_the_board();
  options.append_parameter_override("topics.navigation.topic", std::string("cmd_vel_nav"));
  options.append_parameter_override("topics.navigation.timeout", 60.0);
  options.append_parameter_override("topics.navigation.priority", std::int64_t{10});
  options.append_parameter_override("topics.operator.topic", std::string("cmd_vel_joy"));
  options.append_parameter_override("topics.operator.timeout", 60.0);
  options.append_parameter_override("topics.operator.priority", std::int64_t{100});
  DiffDriveComponent drive{options};
  activate(drive);
  context_.inject("/cmd_vel_nav", twist(0.2));
  ASSERT_TRUE(board_is_told(0.2, 0.2));
  context_.inject("/cmd_vel_joy", twist(0.1));
  ASSERT_TRUE(board_is_told(0.1, 0.1));
  context_.inject("/cmd_vel_nav", twist(0.3));
  ASSERT_TRUE(board_.take_until(1));
  ASSERT_TRUE(board_.take_until(1));
  EXPECT_EQ(board_.left_mps, 0.1);
}

TEST_F(DriveTest, an_input_without_a_topic_and_a_rule_that_is_none_are_named) {
  auto options = on_the_loopback();
  options.append_parameter_override("topics.joy.priority", std::int64_t{10});
  DiffDriveComponent nameless{options};
  EXPECT_THAT(nameless.trigger(Transition::Configure).reason, HasSubstr("topics.joy.topic"));

  auto wrong = on_the_loopback();
  wrong.append_parameter_override("rearm", std::string("neutrl"));
  DiffDriveComponent misspelt{wrong};
  EXPECT_THAT(misspelt.trigger(Transition::Configure).reason, HasSubstr("neutral"));
}

TEST_F(DriveTest, the_open_fault_of_a_base_names_the_device_that_is_on_its_line) {
  auto options = on_the_board();
  options.append_parameter_override("device_lost", std::string("wait"));
  DiffDriveComponent drive{options};
  activate(drive);
  const std::string frame{"\x55\x51\0\0\0\0\0\0\0\0\xA6", 11};  // of a WT901: its accelerometer reads zero
  for (int i = 0; i < 5; ++i) board_.send(frame);
  context_.wait_for_open_faults(1);
  const FaultReason fault = context_.open_faults().front();
  EXPECT_EQ(fault.code, kDeviceLost);
  EXPECT_THAT(fault.text, HasSubstr(pty_->path() + ": 55 bytes came in"));
  EXPECT_THAT(fault.text, HasSubstr("no waveshare frame: they come from a WT901 IMU"));
}

TEST_F(DriveTest, a_line_that_comes_back_is_opened_again_without_a_transition) {
  const std::string link = ::testing::TempDir() + "nacelle_base_line";
  ASSERT_TRUE(pty_->link_as(link));
  auto options = on_the_board();
  options.append_parameter_override("serial_port", link);
  options.append_parameter_override("reopen_timeout", 60.0);
  DiffDriveComponent drive{options};
  activate(drive);
  context_.inject("/cmd_vel", twist(0.2));
  ASSERT_TRUE(board_is_told(0.2, 0.2));

  pty_->hang_up();
  pty_ = io::PtyPair::create().value();
  ASSERT_TRUE(pty_->link_as(link));
  TinyBoard board{*pty_};
  ASSERT_TRUE(board.take_until(131)) << "the driver enables feedback again";
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(board.take_until(1));
  EXPECT_EQ(board.left_mps, 0.0) << "the earlier command is not resumed";
  EXPECT_TRUE(context_.faults().empty());
  EXPECT_EQ(drive.get_current_state().state(), StateId::Active);
}

}  // namespace
}  // namespace nacelle::diff_drive
