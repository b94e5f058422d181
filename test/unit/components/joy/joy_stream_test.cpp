// SPDX-License-Identifier: Apache-2.0
#include "joy/component/joy_stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "joy/component/teleop_twist_joy_component.hpp"
#include "joy/port/scripted_pad.hpp"
#include "pads.hpp"
#include "support/allocation_guard.hpp"
#include "support/recording_host.hpp"

namespace nacelle::joy {
namespace {

using geometry_msgs::msg::Twist;
using sensor_msgs::msg::Joy;

/// A stream without its thread: the test tells the time and hands over the events.
struct StreamRig {
  explicit StreamRig(const JoyOptions& options = {})
      : stream(options, context.clock(), pad, node.create_publisher<Joy>("joy", QoS(10)), node.get_logger(), watch) {
    node.trigger(Transition::Configure);
    node.trigger(Transition::Activate);
    stream.begin(context.clock().now());
    stream.set_active(true);
  }
  void send(std::initializer_list<std::array<int, 3>> events) {
    Bytes bytes;
    const MonotonicTime now = context.clock().now();
    const auto add = [&](int type, int code, int value) {
      const Bytes one =
          ScriptedPad::event(now, static_cast<std::uint16_t>(type), static_cast<std::uint16_t>(code), value);
      bytes.insert(bytes.end(), one.begin(), one.end());
    };
    for (const auto& [type, code, value] : events) add(type, code, value);
    add(input_layout::kSyn, input_layout::kSynReport, 0);
    stream.on_bytes(bytes, now);
  }
  /// Lets the time go by as the reading thread does: the stream is asked whenever it wants to look.
  void run(Duration length) {
    const MonotonicTime end = context.clock().now() + length;
    for (;;) {
      const MonotonicTime now = context.clock().now();
      const MonotonicTime next = std::clamp(stream.look_at(now + 100ms), now, end);
      context.clock().advance(next - now);
      if (next == end) return;
      stream.on_silence(next);
    }
  }
  std::vector<Joy> joys() { return context.published<Joy>("/joy"); }

  test::RecordingContext context;
  LifecycleNode node{"joy_node", NodeOptions{context}};
  ScriptedPad pad{xbox_pad(), io::ScriptedStream::AtEnd::Blocks};
  DeviceWatch watch{node, {}, {"gamepad 0", Duration::max() / 2}, context.clock().now()};
  JoyStream stream;
};

JoyOptions without_repeat() {
  JoyOptions options;
  options.pace.repeat = {};
  return options;
}

constexpr int kKey = input_layout::kKey, kAbs = input_layout::kAbs, kSyn = input_layout::kSyn;

TEST(JoyStream, publishes_a_button_at_once_with_the_kernels_stamp) {
  StreamRig rig{without_repeat()};
  const MonotonicTime pressed = rig.context.clock().now();
  Bytes bytes = ScriptedPad::event(pressed, kKey, BTN_A, 1);
  const Bytes end = ScriptedPad::event(pressed, kSyn, input_layout::kSynReport, 0);
  bytes.insert(bytes.end(), end.begin(), end.end());
  rig.context.clock().advance(7ms);  // the thread is late
  rig.stream.on_bytes(bytes, rig.context.clock().now());
  const auto joys = rig.joys();
  ASSERT_EQ(joys.size(), 1U);
  EXPECT_EQ(joys[0].header.frame_id, "joy");
  EXPECT_EQ(joys[0].buttons[kXboxA], 1);
  EXPECT_EQ(joys[0].axes.size(), 8U);
  EXPECT_EQ(time_of(joys[0].header.stamp), rig.context.clock().wall_now() - 7ms);
}

TEST(JoyStream, joins_moves_of_axes_within_the_coalesce_interval) {
  StreamRig rig{without_repeat()};
  rig.send({{kAbs, ABS_X, -20000}});
  rig.run(400us);
  rig.send({{kAbs, ABS_Y, -30000}});
  EXPECT_TRUE(rig.joys().empty());
  rig.run(10ms);
  ASSERT_EQ(rig.joys().size(), 1U);
  EXPECT_GT(rig.joys()[0].axes[kXboxLeftX], 0.5F);
  EXPECT_GT(rig.joys()[0].axes[kXboxLeftY], 0.8F);
}

TEST(JoyStream, repeats_at_the_autorepeat_rate) {
  StreamRig rig;
  rig.run(1001ms);
  EXPECT_EQ(rig.joys().size(), 21U) << "at 0, 50, ... 1000 ms";
}

TEST(JoyStream, publishes_press_and_release_that_are_read_together) {
  StreamRig rig{without_repeat()};
  const MonotonicTime now = rig.context.clock().now();
  Bytes bytes;
  for (const int value : {1, 0}) {
    for (const Bytes& one : {ScriptedPad::event(now, kKey, BTN_A, value), ScriptedPad::event(now, kSyn, 0, 0)})
      bytes.insert(bytes.end(), one.begin(), one.end());
  }
  rig.stream.on_bytes(bytes, now);
  ASSERT_EQ(rig.joys().size(), 2U);
  EXPECT_EQ(rig.joys()[0].buttons[kXboxA], 1);
  EXPECT_EQ(rig.joys()[1].buttons[kXboxA], 0);
}

TEST(JoyStream, a_lost_pad_is_neutral_once_and_then_silent) {
  StreamRig rig;
  rig.send({{kKey, BTN_A, 1}, {kAbs, ABS_Y, -32768}, {kAbs, ABS_Z, 0}});
  rig.stream.on_break(io::StreamFault::HungUp, rig.context.clock().now());
  const std::size_t count = rig.joys().size();
  const Joy last = rig.joys().back();
  EXPECT_EQ(last.axes.size(), 8U);
  EXPECT_TRUE(std::all_of(last.axes.begin(), last.axes.end(), [](float axis) { return axis == 0.0F; }));
  EXPECT_TRUE(std::all_of(last.buttons.begin(), last.buttons.end(), [](int button) { return button == 0; }));
  ASSERT_EQ(rig.context.open_faults().size(), 1U);
  EXPECT_EQ(rig.context.open_faults()[0].code, kDeviceLost);

  rig.run(5s);
  EXPECT_EQ(rig.joys().size(), count);
  EXPECT_EQ(rig.stream.counters().neutral, 1U);

  rig.stream.on_return(rig.context.clock().now());
  EXPECT_TRUE(rig.context.open_faults().empty());
  rig.run(1ms);
  EXPECT_EQ(rig.joys().size(), count + 1);
}

TEST(JoyStream, a_pad_that_nobody_touches_is_not_lost) {
  StreamRig rig{without_repeat()};
  rig.run(1h);
  EXPECT_TRUE(rig.joys().empty());
  EXPECT_TRUE(rig.context.open_faults().empty());
}

TEST(JoyStream, reads_the_state_anew_when_the_kernel_dropped_events) {
  StreamRig rig{without_repeat()};
  rig.send({{kKey, BTN_A, 1}});
  // The release was dropped, with all that stands behind SYN_DROPPED in its group.
  PadInfo now_is = xbox_pad();
  now_is.axes[ABS_X]->value = 32767;
  rig.pad.set_info(now_is);
  rig.send({{kAbs, ABS_Y, 5000}, {kSyn, input_layout::kSynDropped, 0}, {kKey, BTN_B, 1}});
  const Joy joy = rig.joys().back();
  EXPECT_EQ(joy.buttons[kXboxA], 0);
  EXPECT_EQ(joy.buttons[1], 0) << "it came between the two";
  EXPECT_EQ(joy.axes[kXboxLeftX], -1.0F);
  EXPECT_EQ(joy.axes[kXboxLeftY], 0.0F) << "it came before";
  EXPECT_EQ(rig.stream.counters().overruns, 1U);
}

TEST(JoyStream, another_pad_may_come_back) {
  StreamRig rig{without_repeat()};
  rig.stream.on_break(io::StreamFault::HungUp, rig.context.clock().now());
  PadInfo stick;
  stick.buttons.set(BTN_TRIGGER);
  stick.axes[ABS_X] = stick.axes[ABS_Y] = PadAxis{0, -100, 100};
  rig.pad.set_info(stick);
  rig.stream.on_return(rig.context.clock().now());
  rig.send({{kKey, BTN_TRIGGER, 1}});
  EXPECT_EQ(rig.joys().back().buttons.size(), 1U);
  EXPECT_EQ(rig.joys().back().axes.size(), 2U);
}

TEST(JoyStream, deactivation_is_neutral_once) {
  StreamRig rig;
  rig.send({{kKey, BTN_A, 1}});
  rig.stream.set_active(false);
  const std::size_t count = rig.joys().size();
  EXPECT_EQ(rig.joys().back().buttons[kXboxA], 0);
  rig.send({{kKey, BTN_B, 1}});
  rig.run(1s);
  EXPECT_EQ(rig.joys().size(), count);
}

TEST(JoyStream, taking_events_allocates_nothing) {
  StreamRig rig;
  rig.stream.set_active(false);
  std::vector<Bytes> groups;
  for (int i = 0; i < 500; ++i) {
    Bytes bytes;
    for (const Bytes& one : {ScriptedPad::event({}, kAbs, ABS_X, i * 60), ScriptedPad::event({}, kKey, BTN_A, i % 2),
                             ScriptedPad::event({}, kSyn, 0, 0)})
      bytes.insert(bytes.end(), one.begin(), one.end());
    groups.push_back(bytes);
  }
  const test::AllocationGuard guard;
  for (const Bytes& group : groups) rig.stream.on_bytes(group, rig.context.clock().now());
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_EQ(rig.stream.counters().groups, 500U);
}

// Ten minutes at the stick, in told time: whatever the operator does becomes a command in time, and nothing else does.
TEST(JoyStream, ten_minutes_of_teleoperation_lose_no_command) {
  constexpr unsigned kSeed = 3;
  std::mt19937 random{kSeed};
  StreamRig rig;
  NodeOptions options{rig.context};
  options.parameter_overrides({{"enable_button", std::int64_t{kXboxA}},
                               {"axis_linear.x", std::int64_t{kXboxLeftY}},
                               {"axis_angular.yaw", std::int64_t{kXboxLeftX}}});
  TeleopTwistJoyComponent teleop{options};
  ASSERT_TRUE(teleop.trigger(Transition::Configure).success);
  ASSERT_TRUE(teleop.trigger(Transition::Activate).success);

  // The base: it counts, and keeps the newest.
  std::size_t joys = 0, twists = 0;
  Twist newest;
  LifecycleNode base{"base", NodeOptions{rig.context}};
  const auto hear_joy = base.create_subscription<Joy>("joy", QoS(10), [&](const Joy&) { ++joys; });
  const auto hear_twist = base.create_subscription<Twist>("cmd_vel", QoS(10), [&](const Twist& twist) {
    ++twists;
    newest = twist;
  });
  ASSERT_TRUE(base.trigger(Transition::Configure).success);
  ASSERT_TRUE(base.trigger(Transition::Activate).success);

  rig.send({{kKey, BTN_A, 1}});
  std::size_t moves = 0;
  const MonotonicTime end = rig.context.clock().now() + 10min;
  while (rig.context.clock().now() < end) {
    const auto y = static_cast<int>(random() % 65536) - 32768;
    rig.send({{kAbs, ABS_Y, y}, {kAbs, ABS_X, static_cast<int>(random() % 65536) - 32768}});
    rig.run(2ms);  // the coalesce interval is 1 ms
    rig.context.spin();
    const double share = std::clamp((std::abs((y + 32768.0) / 65535.0 * 2.0 - 1.0) - 0.05) / 0.95, 0.0, 1.0);
    ++moves;
    ASSERT_NEAR(std::abs(newest.linear.x), 0.5 * share, 1e-6) << "move " << moves << ", seed " << kSeed;
    for (auto left = random() % 400; left > 0; left -= std::min<std::uint64_t>(left, 40)) {
      rig.run(std::chrono::milliseconds{std::min<std::uint64_t>(left, 40)});
      rig.context.spin();
    }
  }
  EXPECT_GT(moves, 2000U);
  EXPECT_EQ(joys, rig.stream.counters().published);
  EXPECT_EQ(twists, joys) << "a command for each message";

  rig.stream.on_break(io::StreamFault::HungUp, rig.context.clock().now());
  rig.context.spin();
  EXPECT_EQ(newest, Twist{});
  EXPECT_EQ(twists, joys);
}

}  // namespace
}  // namespace nacelle::joy
