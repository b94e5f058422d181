// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/goal_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <random>

namespace nacelle::action {

std::string to_string(const GoalUUID& id) {
  std::string text;
  for (const std::uint8_t byte : id) text += fmt::format("{:02x}", byte);
  return text;
}

GoalUUID random_goal_id() {
  std::random_device source;
  GoalUUID id{};
  for (std::size_t at = 0; at < id.size(); at += sizeof(std::uint32_t)) {
    const std::uint32_t part = source();
    std::memcpy(id.data() + at, &part, sizeof part);
  }
  return id;
}

const char* to_text(GoalStatus status) {
  switch (status) {
    case GoalStatus::Unknown: break;
    case GoalStatus::Accepted: return "ACCEPTED";
    case GoalStatus::Executing: return "EXECUTING";
    case GoalStatus::Canceling: return "CANCELING";
    case GoalStatus::Succeeded: return "SUCCEEDED";
    case GoalStatus::Canceled: return "CANCELED";
    case GoalStatus::Aborted: return "ABORTED";
  }
  return "UNKNOWN";
}

const char* to_text(GoalEvent event) {
  switch (event) {
    case GoalEvent::Execute: return "execute";
    case GoalEvent::CancelGoal: return "cancel";
    case GoalEvent::Succeed: return "succeed";
    case GoalEvent::Abort: return "abort";
    case GoalEvent::Canceled: return "end as canceled";
  }
  return "unknown";
}

GoalTable::Goal* GoalTable::find(const GoalUUID& id) {
  const auto found = std::find_if(goals_.begin(), goals_.end(), [&](const Goal& goal) { return goal.id == id; });
  return found == goals_.end() ? nullptr : &*found;
}

GoalStatus GoalTable::status_of(const GoalUUID& id) const {
  const Goal* const goal = const_cast<GoalTable*>(this)->find(id);
  return goal == nullptr ? GoalStatus::Unknown : goal->status;
}

bool GoalTable::holds_results() const {
  return std::any_of(goals_.begin(), goals_.end(), [](const Goal& goal) { return !is_active(goal.status); });
}

Result<void, Problem> GoalTable::accept(const GoalUUID& id, WallTime stamp, std::vector<GoalUUID>& dropped) {
  if (find(id) != nullptr) return err(Problem{"goal " + to_string(id), "this id is taken already", ""});
  if (goals_.size() >= options_.max_goals) {
    auto oldest = goals_.end();
    for (auto goal = goals_.begin(); goal != goals_.end(); ++goal) {
      if (!is_active(goal->status) && (oldest == goals_.end() || goal->ended_at < oldest->ended_at)) oldest = goal;
    }
    if (oldest == goals_.end()) {
      return err(Problem{"goal " + to_string(id), fmt::format("{} goals are active already", goals_.size()),
                         "let some of them end, or raise ServerOptions::max_goals"});
    }
    dropped.push_back(oldest->id);
    goals_.erase(oldest);
  }
  goals_.push_back({id, stamp, GoalStatus::Accepted, {}});
  return {};
}

Result<GoalStatus, Problem> GoalTable::apply(const GoalUUID& id, GoalEvent event, MonotonicTime now) {
  Goal* const goal = find(id);
  if (goal == nullptr)
    return err(Problem{"goal " + to_string(id), "is not known", "it has ended, and its result was dropped"});
  const auto next = next_status(goal->status, event);
  if (!next) {
    return err(Problem{"goal " + to_string(id),
                       fmt::format("cannot {} while it is {}", to_text(event), to_text(goal->status)),
                       is_active(goal->status) ? "" : "it has ended"});
  }
  goal->status = *next;
  if (!is_active(*next)) goal->ended_at = now;
  return *next;
}

std::vector<GoalUUID> GoalTable::abort_all(MonotonicTime now) {
  std::vector<GoalUUID> ended;
  for (Goal& goal : goals_) {
    if (!is_active(goal.status)) continue;
    goal.status = GoalStatus::Aborted;
    goal.ended_at = now;
    ended.push_back(goal.id);
  }
  return ended;
}

std::vector<GoalUUID> GoalTable::expire(MonotonicTime now) {
  std::vector<GoalUUID> dropped;
  if (options_.result_timeout < Duration::zero()) return dropped;
  std::erase_if(goals_, [&](const Goal& goal) {
    if (is_active(goal.status) || now - goal.ended_at <= options_.result_timeout) return false;
    dropped.push_back(goal.id);
    return true;
  });
  return dropped;
}

GoalTable::CancelChoice GoalTable::choose(const GoalUUID& id, WallTime stamp) const {
  const bool by_id = id != GoalUUID{};
  const bool by_stamp = stamp != WallTime{};
  const auto cancelable = [](const Goal& goal) { return next_status(goal.status, GoalEvent::CancelGoal).has_value(); };
  CancelChoice choice;
  if (by_id && !by_stamp) {
    const GoalStatus status = status_of(id);
    if (status == GoalStatus::Unknown) {
      choice.code = CancelCode::UnknownGoalId;
    } else if (!next_status(status, GoalEvent::CancelGoal)) {
      choice.code = CancelCode::GoalTerminated;
    } else {
      choice.goals = {id};
    }
    return choice;
  }
  for (const Goal& goal : goals_) {
    const bool meant = (!by_id && !by_stamp) || goal.accepted_at <= stamp || (by_id && goal.id == id);
    if (meant && cancelable(goal)) choice.goals.push_back(goal.id);
  }
  return choice;
}

}  // namespace nacelle::action
