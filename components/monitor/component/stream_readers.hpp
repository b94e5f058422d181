// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "monitor/model/stream_watch.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::monitor {

/// In which form a reader takes a message that it shares with others. Neither costs a copy.
enum class ShareAs : std::uint8_t {
  Reference,  ///< const T&
  Pointer     ///< std::shared_ptr<const T>
};

/// Subscribes a watch to a topic as one message type.
using Subscribe = std::shared_ptr<SubscriptionBase> (*)(Node& node, const std::string& topic, const QoS& qos,
                                                        ShareAs share_as, Announced announced, StreamWatch& watch);

/// A message type that can be read.
struct ReadableType {
  const char* name;
  Subscribe subscribe;
};

/// How a stream named in a parameter is to be read.
struct StreamPlan {
  std::string topic;
  std::vector<const ReadableType*>
      types;  ///< More than one where a topic carries either (Twist and TwistStamped on cmd_vel).
  QoS qos{10};
  bool periodic = true;
};

/// Reads an entry of the parameter `streams`: "/scan" for the robot's own topics, "/front/scan
/// sensor_msgs/msg/LaserScan" for any other.
/// Errors: an unknown type, or a topic that needs a type; the way out names the nearest.
[[nodiscard]] Result<StreamPlan, Problem> plan_stream(std::string_view entry);

}  // namespace nacelle::monitor
