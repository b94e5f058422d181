// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nacelle_bench_msgs/msg/stamped9_float32.hpp>
#include <nacelle_bench_msgs/msg/stamped_bytes.hpp>
#include <string>
#include <utility>

#include "support/recipe.hpp"

namespace nacelle::bench {

using Small = nacelle_bench_msgs::msg::Stamped9Float32;
using Large = nacelle_bench_msgs::msg::StampedBytes;

/// Sets what a driver would set, and leaves the payload as it is: its filling is not the runtime's work.
inline void fill(Small& message, std::uint64_t, std::uint64_t number) {
  message.stamp.nanosec = static_cast<std::uint32_t>(number);
  message.values[0] = 1.0F;
}
inline void fill(Large& message, std::uint64_t bytes, std::uint64_t number) {
  if (message.data.size() != bytes) message.data.resize(bytes);
  message.stamp.nanosec = static_cast<std::uint32_t>(number);
}

/// Subscribes `topic` with the signature that `take` names and calls `on_message()` for each message.
template <typename T, typename F>
std::shared_ptr<void> subscribe(Node& node, const std::string& topic, const QoS& qos, const std::string& take,
                                F on_message) {
  if (take == "shared")
    return node.create_subscription<T>(topic, qos, [on_message](std::shared_ptr<const T> m) { on_message(*m); });
  if (take == "loan")
    return node.create_subscription<T>(topic, qos, [on_message](Loan<T> m) { on_message(std::as_const(*m)); });
  return node.create_subscription<T>(topic, qos, [on_message](const T& m) { on_message(m); });
}

/// Keeps what a recipe's build() has made.
template <typename... Things>
std::shared_ptr<void> keep(Things... things) {
  return std::make_shared<std::tuple<Things...>>(std::move(things)...);
}

}  // namespace nacelle::bench
