// SPDX-License-Identifier: Apache-2.0
#include "drive/odometry_tap.hpp"

#include <nav_msgs/msg/odometry.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "drive/live_figures.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::drive {
namespace {

constexpr Duration kAnswerLimit = 5s;
constexpr const char* kType = "nav_msgs/msg/Odometry";

}  // namespace

Result<OdometryTap, Problem> OdometryTap::open(control::Client client, const std::string& topic) {
  auto reply =
      client.call({{"verb", "topic.listen"}, {"topic", topic}, {"type", kType}, {"show", "raw"}}, kAnswerLimit);
  if (!reply) return err(reply.error());
  return OdometryTap{std::move(client)};
}

const std::optional<StampedPose>& OdometryTap::newest() {
  std::optional<std::string> last;
  while (!ended_) {
    auto frame = client_.receive(0ns);
    ended_ = !frame || (frame.value() && frame.value()->kind == control::FrameKind::Fault);
    if (ended_ || !frame.value()) break;
    if (frame.value()->kind == control::FrameKind::Item) last = as_text(frame.value()->payload);
  }
  bytes_.clear();
  if (!last || !from_hex(*last, bytes_)) return newest_;
  nav_msgs::msg::Odometry odometry;
  if (!msgs::from_cdr(bytes_, odometry)) return newest_;
  const auto& position = odometry.pose.pose.position;
  const auto& q = odometry.pose.pose.orientation;
  newest_ = StampedPose{time_of(odometry.header.stamp), {position.x, position.y, yaw_of({q.x, q.y, q.z, q.w})}};
  return newest_;
}

}  // namespace nacelle::drive
