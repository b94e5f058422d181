// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <vector>

#include "cli/whom.hpp"
#include "nacelle/host/action_goal.hpp"

namespace nacelle::cli {

/// The servers and clients of an action.
struct ActionEnds {
  std::set<std::string> types;
  std::map<std::string, std::string> servers, clients;  ///< Node to type.
};
/// Returns every action of the container's graph (answers/graph_verbs.hpp), by name. As in ROS 2, the feedback topic
/// decides: its publishers are servers, its subscribers are clients.
[[nodiscard]] std::map<std::string, ActionEnds> actions_of(const nlohmann::json& graph);
[[nodiscard]] std::vector<std::string> names_of(const std::map<std::string, ActionEnds>& actions);

/// The arguments of `action send_goal`.
struct GoalWish {
  Whom whom;
  std::string action, type, goal = "{}";
  bool as_json = false, feedback = false, from_stdin = false;
  double timeout_s = 0;  ///< 0: none.
};
/// Sends the goal, prints its progress and blocks until it ends. The first signal cancels the goal. Returns the exit
/// code.
[[nodiscard]] int send_goal(const GoalWish& wish);

}  // namespace nacelle::cli
