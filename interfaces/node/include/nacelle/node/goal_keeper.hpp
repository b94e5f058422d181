// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "nacelle/base/mutex.hpp"
#include "nacelle/node/goal_table.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::action::detail {

/// What a goal keeper tells to the outside, in types that it does not know. Called with the keeper's lock held: it publishes and
/// answers, and runs no code of a component.
class GoalOutlets {
 public:
  virtual ~GoalOutlets() = default;
  virtual void publish_status(const std::vector<GoalTable::Goal>& goals) = 0;
  virtual void publish_feedback(const GoalUUID& id, const void* feedback) = 0;
  /// `result` is an A::Result; null: one with its defaults.
  virtual void answer_result(const RequestId& request, GoalStatus status, const void* result) = 0;
  /// There are results that will have to be dropped (or none any more): a timer begins or ends.
  virtual void watch_results(bool any) = 0;
};

/// Keeps the goals of an action server, their results and the clients that wait: the part that does not depend on the type.
///
/// Ownership: shared by the server and its goal handles; handles that outlive the server find it closed. Threads: any.
class GoalKeeper final : public GateListener {
 public:
  GoalKeeper(GoalOutlets& outlets, const Clock& clock, const ServerOptions& options)
      : clock_(clock), table_(options), outlets_(&outlets) {}

  /// Errors: as GoalTable::accept().
  [[nodiscard]] Result<void, Problem> accept(const GoalUUID& id, WallTime stamp, bool execute);
  void attach(const GoalUUID& id, const std::shared_ptr<void>& handle);
  void publish_status();
  /// Returns the handle given to attach(), or null if it was released.
  [[nodiscard]] std::shared_ptr<void> handle_of(const GoalUUID& id) const;
  [[nodiscard]] GoalTable::CancelChoice choose(const GoalUUID& id, WallTime stamp) const;
  [[nodiscard]] GoalStatus status_of(const GoalUUID& id) const;
  [[nodiscard]] WallTime accepted_at(const GoalUUID& id) const;
  /// False where it comes too late: the goal has ended meanwhile.
  [[nodiscard]] bool cancel(const GoalUUID& id);
  /// Answers at once if the result is there or never will be; else when it comes.
  void request_result(const GoalUUID& id, const RequestId& request);

  // For goal handles. Returns false if the server has ended the goal: it was deactivated, or is gone.
  bool execute(const GoalUUID& id);
  bool feedback(const GoalUUID& id, const void* feedback);
  /// Errors: IllegalTransition.
  bool end(const GoalUUID& id, GoalEvent event, std::shared_ptr<const void> result);
  /// Its last handle is gone: it ends as canceled if it has not ended.
  void forsake(const GoalUUID& id) noexcept;

  void expire();
  void before_gate_closes() noexcept override;
  /// Nothing leaves any more; goals that are active are aborted first.
  void close() noexcept;

 private:
  struct Goal {
    std::weak_ptr<void> handle;
    std::shared_ptr<const void> result;
    std::vector<RequestId> waiting;
    bool ended_by_server = false;
  };
  [[nodiscard]] bool is_lost(const GoalUUID& id) const NACELLE_REQUIRES(mutex_);
  void abort_all() NACELLE_REQUIRES(mutex_);
  void settle(const GoalUUID& id, GoalStatus status) NACELLE_REQUIRES(mutex_);
  void drop(const std::vector<GoalUUID>& ids) NACELLE_REQUIRES(mutex_);
  [[nodiscard]] MonotonicTime now() const { return clock_.now(); }

  const Clock& clock_;
  mutable Mutex mutex_;
  GoalTable table_ NACELLE_GUARDED_BY(mutex_);
  std::map<GoalUUID, Goal> goals_ NACELLE_GUARDED_BY(mutex_);
  GoalOutlets* outlets_ NACELLE_GUARDED_BY(mutex_);  // null: closed
};

}  // namespace nacelle::action::detail
