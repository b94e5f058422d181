// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/goal_keeper.hpp"

#include <utility>

namespace nacelle::action::detail {

Result<void, Problem> GoalKeeper::accept(const GoalUUID& id, WallTime stamp, bool execute) {
  const LockGuard lock(mutex_);
  drop(table_.expire(now()));
  std::vector<GoalUUID> dropped;
  auto accepted = table_.accept(id, stamp, dropped);
  drop(dropped);
  if (!accepted) return accepted;
  goals_[id] = {};
  if (execute) static_cast<void>(table_.apply(id, GoalEvent::Execute, now()));
  return {};
}

void GoalKeeper::attach(const GoalUUID& id, const std::shared_ptr<void>& handle) {
  const LockGuard lock(mutex_);
  goals_[id].handle = handle;
}

void GoalKeeper::publish_status() {
  const LockGuard lock(mutex_);
  if (outlets_ != nullptr) outlets_->publish_status(table_.goals());
}

std::shared_ptr<void> GoalKeeper::handle_of(const GoalUUID& id) const {
  const LockGuard lock(mutex_);
  const auto found = goals_.find(id);
  return found == goals_.end() ? nullptr : found->second.handle.lock();
}

GoalTable::CancelChoice GoalKeeper::choose(const GoalUUID& id, WallTime stamp) const {
  const LockGuard lock(mutex_);
  return table_.choose(id, stamp);
}

GoalStatus GoalKeeper::status_of(const GoalUUID& id) const {
  const LockGuard lock(mutex_);
  return table_.status_of(id);
}

WallTime GoalKeeper::accepted_at(const GoalUUID& id) const {
  const LockGuard lock(mutex_);
  for (const auto& goal : table_.goals()) {
    if (goal.id == id) return goal.accepted_at;
  }
  return {};
}

bool GoalKeeper::cancel(const GoalUUID& id) {
  const LockGuard lock(mutex_);
  return static_cast<bool>(table_.apply(id, GoalEvent::CancelGoal, now()));
}

void GoalKeeper::request_result(const GoalUUID& id, const RequestId& request) {
  const LockGuard lock(mutex_);
  if (outlets_ == nullptr) return;
  drop(table_.expire(now()));
  const GoalStatus status = table_.status_of(id);
  if (is_active(status)) {
    goals_[id].waiting.push_back(request);
  } else {
    outlets_->answer_result(request, status, status == GoalStatus::Unknown ? nullptr : goals_[id].result.get());
  }
}

bool GoalKeeper::is_lost(const GoalUUID& id) const {
  const auto found = goals_.find(id);
  return outlets_ == nullptr || (found != goals_.end() && found->second.ended_by_server);
}

bool GoalKeeper::execute(const GoalUUID& id) {
  const LockGuard lock(mutex_);
  if (is_lost(id)) return false;
  if (const auto done = table_.apply(id, GoalEvent::Execute, now()); !done)
    throw IllegalTransition(done.error().text());
  outlets_->publish_status(table_.goals());
  return true;
}

bool GoalKeeper::feedback(const GoalUUID& id, const void* feedback) {
  const LockGuard lock(mutex_);
  if (is_lost(id) || !is_active(table_.status_of(id))) return false;
  outlets_->publish_feedback(id, feedback);
  return true;
}

bool GoalKeeper::end(const GoalUUID& id, GoalEvent event, std::shared_ptr<const void> result) {
  const LockGuard lock(mutex_);
  if (is_lost(id)) return false;
  const auto status = table_.apply(id, event, now());
  if (!status) throw IllegalTransition(status.error().text());
  goals_[id].result = std::move(result);
  settle(id, status.value());
  outlets_->publish_status(table_.goals());
  outlets_->watch_results(true);
  return true;
}

void GoalKeeper::forsake(const GoalUUID& id) noexcept {
  const LockGuard lock(mutex_);
  if (table_.status_of(id) == GoalStatus::Unknown) goals_.erase(id);
  if (is_lost(id) || !is_active(table_.status_of(id))) return;
  static_cast<void>(table_.apply(id, GoalEvent::CancelGoal, now()));  // unless it is being canceled already
  const auto status = table_.apply(id, GoalEvent::Canceled, now());
  settle(id, status.value());
  outlets_->publish_status(table_.goals());
  outlets_->watch_results(true);
}

void GoalKeeper::expire() {
  const LockGuard lock(mutex_);
  if (outlets_ == nullptr) return;
  drop(table_.expire(now()));
  outlets_->watch_results(table_.holds_results());
}

void GoalKeeper::before_gate_closes() noexcept {
  const LockGuard lock(mutex_);
  if (outlets_ != nullptr) abort_all();
}

void GoalKeeper::close() noexcept {
  const LockGuard lock(mutex_);
  if (outlets_ == nullptr) return;
  abort_all();
  outlets_ = nullptr;
}

void GoalKeeper::abort_all() {
  const auto ended = table_.abort_all(now());
  for (const GoalUUID& id : ended) {
    goals_[id].ended_by_server = true;
    settle(id, GoalStatus::Aborted);
  }
  if (ended.empty()) return;
  outlets_->publish_status(table_.goals());
  outlets_->watch_results(true);
}

void GoalKeeper::settle(const GoalUUID& id, GoalStatus status) {
  Goal& goal = goals_[id];
  for (const RequestId& request : std::exchange(goal.waiting, {}))
    outlets_->answer_result(request, status, goal.result.get());
}

void GoalKeeper::drop(const std::vector<GoalUUID>& ids) {
  for (const GoalUUID& id : ids) {
    const auto found = goals_.find(id);
    if (found == goals_.end()) continue;
    // Who holds the handle of a goal that the server has ended may still learn of it, however late.
    if (found->second.ended_by_server && !found->second.handle.expired()) {
      found->second.result = nullptr;
    } else {
      goals_.erase(found);
    }
  }
}

}  // namespace nacelle::action::detail
