// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::answers {

/// Why a robot refuses a request or a component. TopicTypes and QosMismatch have the same codes as the findings of
/// `nacelle check`.
enum class RobotFault : std::uint8_t {
  NotRunning,   ///< The robot is starting, stopping or down. Value: its phase.
  TopicTypes,   ///< The new component uses another type for a topic. Value: the topic.
  QosMismatch,  ///< QoS is incompatible with another component's. Value: the topic.
};
[[nodiscard]] constexpr const char* code_text(RobotFault fault) {
  switch (fault) {
    case RobotFault::NotRunning: return "container.not_running";
    case RobotFault::TopicTypes: return "type.of_topic";
    case RobotFault::QosMismatch: return "qos.mismatch";
  }
  return "";
}

}  // namespace nacelle::answers
