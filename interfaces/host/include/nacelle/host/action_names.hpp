// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

/// What an action is made of on the wire: three services and two topics below its name.
/// Source: ROS 2's design article "Actions"; names.c and graph.c of rcl_action (jazzy).
namespace nacelle::action {

inline constexpr std::string_view kSendGoal = "/_action/send_goal";
inline constexpr std::string_view kGetResult = "/_action/get_result";
inline constexpr std::string_view kCancelGoal = "/_action/cancel_goal";
inline constexpr std::string_view kFeedback = "/_action/feedback";
inline constexpr std::string_view kStatus = "/_action/status";

[[nodiscard]] inline std::string part_name(std::string_view action, std::string_view part) {
  return std::string{action} += part;
}
/// A topic or service that is part of an action; lists leave it out unless they are asked for hidden ones.
[[nodiscard]] inline bool is_action_part(std::string_view name) {
  return name.find("/_action/") != std::string_view::npos;
}

/// Returns the action that a topic belongs to: a publisher of its feedback is a server, a subscriber a client.
struct ActionName {
  std::string name;  ///< "/fibonacci"
  std::string type;  ///< "example_interfaces/action/Fibonacci"
};
/// Nothing for every topic but an action's feedback.
[[nodiscard]] inline std::optional<ActionName> action_of_topic(std::string_view topic, std::string_view type) {
  constexpr std::string_view kMessage = "_FeedbackMessage";
  if (!topic.ends_with(kFeedback) || !type.ends_with(kMessage)) return std::nullopt;
  topic.remove_suffix(kFeedback.size());
  type.remove_suffix(kMessage.size());
  return ActionName{std::string{topic}, std::string{type}};
}

}  // namespace nacelle::action
