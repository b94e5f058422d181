// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::answers {

/// Why a robot refuses a request or a component. TopicTypes and QosMismatch have the codes of the same findings of `nacelle check`.
enum class RobotFault : std::uint8_t {
  NotRunning,  ///< The robot is starting, stopping or down. Value: its phase.
  TopicTypes,  ///< The new component and another one have two types for a topic. Value: the topic.
  QosMismatch,  ///< Quality of service keeps the new component and another one from exchanging messages. Value: the topic.
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
