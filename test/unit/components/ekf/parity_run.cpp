// SPDX-License-Identifier: Apache-2.0
#include "parity_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

namespace nacelle::ekf::parity {
namespace {

WallTime wall(std::int64_t ns) { return WallTime{Duration{ns}}; }

class StreamClock final : public Clock {
 public:
  [[nodiscard]] MonotonicTime now() const override { return {Duration{at_ns}}; }
  [[nodiscard]] WallTime wall_now() const override { return wall(at_ns); }
  std::int64_t at_ns{kStart_ns};
};

RigidTransform transform_of(const Mounting& m) {
  return {Eigen::Quaterniond{m.q[3], m.q[0], m.q[1], m.q[2]}, {m.p[0], m.p[1], m.p[2]}};
}
template <typename Out>
void write(const Vector& v, Out& out) {
  out.x = v[0];
  out.y = v[1];
  out.z = v[2];
}
void write(const Quaternion& q, geometry_msgs::msg::Quaternion& out) {
  out.x = q[0];
  out.y = q[1];
  out.z = q[2];
  out.w = q[3];
}

FilterOptions filter_options(const Stream& s) {
  FilterOptions o;
  StateMatrix noise, initial;
  for (int i = 0; i < kStates; ++i) {
    o.initial.mean[i] = s.initial_state[static_cast<std::size_t>(i)];
    for (int j = 0; j < kStates; ++j) {
      noise(i, j) = s.process_noise[static_cast<std::size_t>(i * kStates + j)];
      initial(i, j) = s.initial_covariance[static_cast<std::size_t>(i * kStates + j)];
    }
  }
  o.process_noise = ProcessNoise{noise};
  o.initial.covariance = initial;
  o.sensor_timeout = from_seconds(s.sensor_timeout_s);
  o.timeout_from_stamp = true;
  o.period = from_seconds(1.0 / s.frequency_hz);
  o.two_d_mode = s.two_d;
  o.predict_to_current_time = s.predict_to_now;
  o.dynamic_process_noise = s.dynamic_noise;
  o.control = {s.controlled, from_seconds(s.control_timeout_s), s.limits, s.gains, s.slowing_limits, s.slowing_gains};
  return o;
}

InputOptions input_options(const parity::Input& in, std::size_t number) {
  constexpr std::array kKinds{InputKind::Odometry, InputKind::Pose, InputKind::Twist, InputKind::Imu};
  InputOptions o;
  o.kind = kKinds[static_cast<std::size_t>(in.kind)];
  o.name = "in" + std::to_string(number);
  o.config = static_cast<StateMask>(in.mask);
  o.differential = in.differential;
  o.relative = in.relative;
  o.pose_use_child_frame = in.pose_of_child;
  o.remove_gravitational_acceleration = in.remove_gravity;
  o.pose_gate = o.twist_gate = o.acceleration_gate = in.gate;
  return o;
}

void take(ekf::Input& input, const Message& m) {
  const std::string number = std::to_string(m.input);
  builtin_interfaces::msg::Time stamp;
  stamp = wall(m.stamp_ns);
  geometry_msgs::msg::PoseWithCovariance pose;
  write(m.position, pose.pose.position);
  write(m.orientation, pose.pose.orientation);
  pose.covariance = m.pose_covariance;
  geometry_msgs::msg::TwistWithCovariance twist;
  write(m.linear, twist.twist.linear);
  write(m.angular, twist.twist.angular);
  twist.covariance = m.twist_covariance;
  switch (input.options().kind) {
    case InputKind::Odometry: {
      nav_msgs::msg::Odometry out;
      out.header.stamp = stamp;
      out.header.frame_id = "world" + number;
      out.child_frame_id = "sensor" + number;
      out.pose = pose;
      out.twist = twist;
      return input.take(out);
    }
    case InputKind::Pose: {
      geometry_msgs::msg::PoseWithCovarianceStamped out;
      out.header.stamp = stamp;
      out.header.frame_id = "world" + number;
      out.pose = pose;
      return input.take(out);
    }
    case InputKind::Twist: {
      geometry_msgs::msg::TwistWithCovarianceStamped out;
      out.header.stamp = stamp;
      out.header.frame_id = "sensor" + number;
      out.twist = twist;
      return input.take(out);
    }
    case InputKind::Imu: break;
  }
  sensor_msgs::msg::Imu out;
  out.header.stamp = stamp;
  out.header.frame_id = "sensor" + number;
  out.orientation = pose.pose.orientation;
  out.angular_velocity = twist.twist.angular;
  write(m.acceleration, out.linear_acceleration);
  std::copy_n(m.pose_covariance.begin(), 9, out.orientation_covariance.begin());
  std::copy_n(m.twist_covariance.begin(), 9, out.angular_velocity_covariance.begin());
  out.linear_acceleration_covariance = m.acceleration_covariance;
  input.take(out);
}

}  // namespace

std::array<double, 46> run(const Stream& s, const Switches& switches) {
  StreamClock clock;
  spatial::TransformBuffer buffer;
  EkfOptions options;
  options.robot_localization_rotations = switches.robot_localization_rotations;
  options.filter = filter_options(s);
  for (const parity::Input& in : s.inputs) {
    options.inputs.push_back(input_options(in, options.inputs.size()));
    options.filter.parts += ekf::Input::parts_of(options.inputs.back());
  }
  Filter filter{options.filter};
  std::vector<std::unique_ptr<ekf::Input>> inputs;
  std::uint16_t next = 0;
  for (std::size_t i = 0; i < s.inputs.size(); ++i) {
    const std::string number = std::to_string(i);
    EXPECT_TRUE(buffer.insert("odom", "world" + number, WallTime{}, transform_of(s.inputs[i].X_WM),
                              spatial::Permanence::Static));
    EXPECT_TRUE(buffer.insert("base_link", "sensor" + number, WallTime{}, transform_of(s.inputs[i].X_BS),
                              spatial::Permanence::Static));
    inputs.push_back(
        std::make_unique<ekf::Input>(options.inputs[i], InputContext{&filter, &buffer, &options, &clock}, next));
    next = static_cast<std::uint16_t>(next + inputs.back()->parts().size());
  }

  auto message = s.messages.begin();
  auto command = s.commands.begin();
  for (const std::int64_t tick_ns : s.ticks_ns) {
    for (;;) {
      const bool has_message = message != s.messages.end() && message->arrival_ns <= tick_ns;
      const bool has_command = command != s.commands.end() && command->arrival_ns <= tick_ns;
      if (!has_message && !has_command) break;
      if (has_command && (!has_message || command->arrival_ns <= message->arrival_ns)) {
        filter.command(command->velocity, wall(command->arrival_ns));
        ++command;
        continue;
      }
      clock.at_ns = message->arrival_ns;
      take(*inputs[static_cast<std::size_t>(message->input)], *message);
      ++message;
    }
    clock.at_ns = tick_ns;
    filter.step(clock.wall_now(), clock.now());
  }
  std::array<double, 15> mean{};
  for (int i = 0; i < kStates; ++i) mean[static_cast<std::size_t>(i)] = filter.belief().mean[i];
  return end_state(s, filter.stamp().nanoseconds(), mean, filter.belief().covariance);
}

}  // namespace nacelle::ekf::parity
