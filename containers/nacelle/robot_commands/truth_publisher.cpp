// SPDX-License-Identifier: Apache-2.0
#include "robot_commands/truth_publisher.hpp"

#include <poll.h>

#include <algorithm>
#include <cmath>
#include <nav_msgs/msg/odometry.hpp>

#include "cli/asking.hpp"
#include "cli/program.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "process/stop_signal.hpp"
#include "simulation/port/truth_file.hpp"

namespace nacelle::cli {
namespace {

nav_msgs::msg::Odometry message_of(const simulation::Truth& truth, WallTime stamp) {
  nav_msgs::msg::Odometry message;
  message.header.stamp = stamp;
  message.header.frame_id = "world";
  message.child_frame_id = "base_link";
  message.pose.pose.position.x = truth.x_m;
  message.pose.pose.position.y = truth.y_m;
  message.pose.pose.orientation.z = std::sin(0.5 * truth.yaw_rad);
  message.pose.pose.orientation.w = std::cos(0.5 * truth.yaw_rad);
  message.twist.twist.linear.x = truth.speed_mps;
  message.twist.twist.angular.z = truth.yaw_rate_rps;
  return message;
}

}  // namespace

int publish_truth(const std::string& directory, const TruthTopic& wish) {
  const process::StopSignal stop;
  const SystemClock clock;
  const std::string topic = wish.topic.starts_with('/') ? wish.topic : "/" + wish.topic;
  auto client = connect(wish.container);
  if (!client) return client.error();
  const auto handle = client.value().open_writer(topic, "nav_msgs/msg/Odometry", kAnswerLimit);
  if (!handle) return complain(handle.error());
  const Duration period = from_seconds(1.0 / wish.rate_hz);
  for (MonotonicTime next = clock.now(); !stop.is_raised();) {
    const auto truth = simulation::read_truth(directory + "/truth");
    if (!truth) return complain({directory, "the world has ended, or none runs there", "name its folder with --dir"});
    if (auto sent = client.value().publish(handle.value(), msgs::to_cdr(message_of(truth.value(), clock.wall_now())));
        !sent)
      return stop.is_raised() ? kDone : complain(sent.error());
    next = std::max(next + period, clock.now());
    pollfd wait{stop.descriptor(), POLLIN, 0};
    ::poll(&wait, 1, static_cast<int>(std::max(Duration::zero(), next - clock.now()) / 1ms));
  }
  return kDone;
}

}  // namespace nacelle::cli
