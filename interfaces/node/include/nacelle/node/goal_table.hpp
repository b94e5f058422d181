// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/host/action_goal.hpp"

namespace nacelle::action {

/// The goals of one action server and where each of them stands; nothing else.
///
/// Threads: pure; one at a time. Times are arguments.
class GoalTable {
 public:
  struct Goal {
    GoalUUID id;
    WallTime accepted_at;
    GoalStatus status = GoalStatus::Accepted;
    MonotonicTime ended_at;  ///< Once it is not active.
  };
  /// CancelGoal_Response::return_code of action_msgs.
  enum class CancelCode : std::int8_t { None = 0, Rejected = 1, UnknownGoalId = 2, GoalTerminated = 3 };
  struct CancelChoice {
    CancelCode code = CancelCode::None;
    std::vector<GoalUUID> goals;  ///< To be asked one by one.
  };

  explicit GoalTable(const ServerOptions& options) : options_(options) {}

  /// Notes a new goal. Returns the goal whose result had to go for it, if any, in `dropped`.
  /// Errors: the id is taken; max_goals are active.
  [[nodiscard]] Result<void, Problem> accept(const GoalUUID& id, WallTime stamp, std::vector<GoalUUID>& dropped);
  /// Errors: there is no such goal; the event is not allowed in its status. Nothing changes then.
  [[nodiscard]] Result<GoalStatus, Problem> apply(const GoalUUID& id, GoalEvent event, MonotonicTime now);
  /// Ends whatever is active, as aborted; also what only waits to be executed. Returns those that it ended.
  [[nodiscard]] std::vector<GoalUUID> abort_all(MonotonicTime now);
  /// Drops what ended longer than result_timeout ago, and returns it.
  [[nodiscard]] std::vector<GoalUUID> expire(MonotonicTime now);

  [[nodiscard]] GoalStatus status_of(const GoalUUID& id) const;
  /// Whom a request to cancel means: by id, by time of acceptance (at or before the stamp), by both, or (both zero) everybody.
  /// Goals that are being canceled already, or have ended, are not chosen; the id of such a one gives GoalTerminated.
  /// Source: rcl_action_process_cancel_request() (jazzy).
  [[nodiscard]] CancelChoice choose(const GoalUUID& id, WallTime stamp) const;
  /// In the order of acceptance.
  [[nodiscard]] const std::vector<Goal>& goals() const { return goals_; }
  [[nodiscard]] bool holds_results() const;

 private:
  [[nodiscard]] Goal* find(const GoalUUID& id);

  const ServerOptions options_;
  std::vector<Goal> goals_;
};

}  // namespace nacelle::action
