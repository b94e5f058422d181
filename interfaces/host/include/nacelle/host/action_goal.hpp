// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

#include "nacelle/base/time.hpp"

/// Actions: goals that take their time, with feedback on the way and a result at the end; rclcpp_action's words and meaning.
namespace nacelle::action {

/// Names a goal everywhere; chosen by the client, random. All zeros stands for "any" in a request to cancel.
using GoalUUID = std::array<std::uint8_t, 16>;
/// 32 hexadecimal digits.
[[nodiscard]] std::string to_string(const GoalUUID& id);
/// Threads: any.
[[nodiscard]] GoalUUID random_goal_id();

/// action_msgs/msg/GoalStatus.
enum class GoalStatus : std::int8_t {
  Unknown = 0,
  Accepted = 1,  ///< Waits to be executed.
  Executing = 2,
  Canceling = 3,  ///< A request to cancel was accepted; the component cleans up.
  Succeeded = 4,
  Canceled = 5,
  Aborted = 6,
};
/// "ACCEPTED", "EXECUTING", ..., "UNKNOWN".
[[nodiscard]] const char* to_text(GoalStatus status);
[[nodiscard]] constexpr bool is_active(GoalStatus status) {
  return status == GoalStatus::Accepted || status == GoalStatus::Executing || status == GoalStatus::Canceling;
}

/// What moves a goal from one status to the next.
enum class GoalEvent : std::uint8_t { Execute, CancelGoal, Succeed, Abort, Canceled };
[[nodiscard]] const char* to_text(GoalEvent event);

/// The status after an event; nothing where the event is not allowed.
/// Source: goal_state_machine.c of rcl_action (jazzy).
[[nodiscard]] constexpr std::optional<GoalStatus> next_status(GoalStatus from, GoalEvent event) {
  const bool executes = from == GoalStatus::Executing || from == GoalStatus::Canceling;
  switch (event) {
    case GoalEvent::Execute:
      if (from == GoalStatus::Accepted) return GoalStatus::Executing;
      break;
    case GoalEvent::CancelGoal:
      if (from == GoalStatus::Accepted || from == GoalStatus::Executing) return GoalStatus::Canceling;
      break;
    case GoalEvent::Succeed:
      if (executes) return GoalStatus::Succeeded;
      break;
    case GoalEvent::Abort:
      if (executes) return GoalStatus::Aborted;
      break;
    case GoalEvent::Canceled:
      if (from == GoalStatus::Canceling) return GoalStatus::Canceled;
      break;
  }
  return std::nullopt;
}

/// What a server says to a goal.
enum class GoalResponse : std::int8_t { REJECT = 1, ACCEPT_AND_EXECUTE = 2, ACCEPT_AND_DEFER = 3 };
/// What a server says to a request to cancel a goal.
enum class CancelResponse : std::int8_t { REJECT = 1, ACCEPT = 2 };
/// How a goal ended, for its client. UNKNOWN: the server went away, or has dropped the result.
enum class ResultCode : std::int8_t {
  UNKNOWN = static_cast<std::int8_t>(GoalStatus::Unknown),
  SUCCEEDED = static_cast<std::int8_t>(GoalStatus::Succeeded),
  CANCELED = static_cast<std::int8_t>(GoalStatus::Canceled),
  ABORTED = static_cast<std::int8_t>(GoalStatus::Aborted),
};

/// How many goals a server keeps, and for how long.
struct ServerOptions {
  /// A result is dropped so long after its goal's end; later requests for it are answered with STATUS_UNKNOWN. Negative: never.
  /// Source: rcl_action_server_get_default_options() of jazzy.
  Duration result_timeout = std::chrono::seconds{10};
  /// Goals that are active or have a result waiting. A further goal takes the place of the oldest result; while all are active
  /// it is refused. rcl knows no such bound.
  std::size_t max_goals = 64;
};

/// A call that the goal's status does not allow: succeed() after its end, canceled() without a cancel request.
/// Source: rclcpp_action, which throws here too.
struct IllegalTransition : std::logic_error {
  using logic_error::logic_error;
};

}  // namespace nacelle::action
