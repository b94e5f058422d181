// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "nacelle/base/mutex.hpp"
#include "nacelle/host/action_goal.hpp"
#include "nacelle/host/action_names.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::action {

/// Something of an action to wait for. Copies share it. As rclcpp_action's, but waiting where it would never end is an error and
/// not a deadlock. Threads: one; it does not outlive its client.
template <typename T>
class Future {
 public:
  Future() = default;
  Future(std::shared_future<T> future, std::function<std::string()> why_not_wait)
      : future_(std::move(future)), why_not_wait_(std::move(why_not_wait)) {}
  [[nodiscard]] bool valid() const { return future_.valid(); }
  /// Errors: exceptions::WaitsForItself in a callback that keeps the answer from being taken.
  std::future_status wait_for(Duration limit) const {
    check();
    return future_.wait_for(limit);
  }
  /// Waits if need be. Errors: as wait_for().
  [[nodiscard]] T get() const {
    check();
    return future_.get();
  }

 private:
  void check() const {
    if (future_.wait_for(Duration::zero()) == std::future_status::ready) return;
    if (const std::string why = why_not_wait_(); !why.empty()) throw exceptions::WaitsForItself(why);
  }
  std::shared_future<T> future_;
  std::function<std::string()> why_not_wait_;
};

template <typename A>
class Client;

/// A goal that a server has accepted, for the client that sent it. Threads: any.
template <typename A>
class ClientGoalHandle final {
 public:
  using SharedPtr = std::shared_ptr<ClientGoalHandle>;
  using Feedback = typename A::Feedback;
  struct WrappedResult {
    GoalUUID goal_id{};
    ResultCode code = ResultCode::UNKNOWN;
    std::shared_ptr<typename A::Result> result;  ///< Never null; with the definition's defaults where none came.
  };
  using FeedbackCallback = std::function<void(SharedPtr, std::shared_ptr<const Feedback>)>;
  using ResultCallback = std::function<void(const WrappedResult&)>;

  ClientGoalHandle(const GoalUUID& id, WallTime stamp, FeedbackCallback on_feedback)
      : id_(id), stamp_(stamp), on_feedback_(std::move(on_feedback)) {}

  [[nodiscard]] const GoalUUID& get_goal_id() const { return id_; }
  [[nodiscard]] WallTime get_goal_stamp() const { return stamp_; }
  /// What the server said last.
  [[nodiscard]] GoalStatus get_status() const { return status_.load(std::memory_order_acquire); }

 private:
  friend class Client<A>;
  const GoalUUID id_;
  const WallTime stamp_;
  std::atomic<GoalStatus> status_{GoalStatus::Accepted};
  std::promise<WrappedResult> promise_;
  const std::shared_future<WrappedResult> result_{promise_.get_future()};
  Mutex mutex_;
  FeedbackCallback on_feedback_ NACELLE_GUARDED_BY(mutex_);
  std::vector<ResultCallback> on_result_ NACELLE_GUARDED_BY(mutex_);
  bool asked_ NACELLE_GUARDED_BY(mutex_) = false;  // for the result
};

/// Sends goals to one action; see create_client(). Sending never blocks.
///
/// Callbacks run on the node's executor, in the client's callback group. Without a server that is active a goal counts as
/// rejected at once: the callbacks run before the call returns. As in rclcpp, feedback that still waits for its turn when the
/// result arrives is dropped. A goal whose handle was released gets no feedback.
/// Ownership: the component's. When it goes no callback runs any more; goals that it has sent go on.
/// Threads: any.
template <typename A>
class Client final {
 public:
  using SharedPtr = std::shared_ptr<Client>;
  using Goal = typename A::Goal;
  using GoalHandle = ClientGoalHandle<A>;
  using WrappedResult = typename GoalHandle::WrappedResult;
  using CancelResponse = typename A::Impl::CancelGoalService::Response;
  /// The handle; null if the goal was rejected.
  using GoalResponseCallback = std::function<void(std::shared_ptr<GoalHandle>)>;
  using FeedbackCallback = typename GoalHandle::FeedbackCallback;
  using ResultCallback = typename GoalHandle::ResultCallback;
  /// Null if no server was there.
  using CancelCallback = std::function<void(std::shared_ptr<CancelResponse>)>;
  struct SendGoalOptions {
    GoalResponseCallback goal_response_callback{};
    FeedbackCallback feedback_callback{};
    ResultCallback result_callback{};
  };

  Client(Node& node, const std::string& name, const CallbackGroup::SharedPtr& group);
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  [[nodiscard]] const std::string& get_action_name() const { return name_; }
  /// All five parts are there. Source: rcl_action_server_is_available.
  [[nodiscard]] bool action_server_is_ready() const {
    return send_goal_->service_is_ready() && get_result_->service_is_ready() && cancel_goal_->service_is_ready() &&
           feedback_->get_publisher_count() != 0 && status_->get_publisher_count() != 0;
  }
  /// Blocks until a server is there and active; negative: without an end. For threads of one's own: in a callback it keeps the
  /// whole executor waiting, where a timer that asks action_server_is_ready() would not. Returns action_server_is_ready().
  bool wait_for_action_server(Duration timeout = Duration{-1}) const;

  /// The future's value: the goal's handle, null if it was rejected.
  Future<std::shared_ptr<GoalHandle>> async_send_goal(const Goal& goal, SendGoalOptions options = {});
  /// Asks for the result once, however often it is called.
  Future<WrappedResult> async_get_result(const std::shared_ptr<GoalHandle>& goal, ResultCallback on_result = {});
  Future<std::shared_ptr<CancelResponse>> async_cancel_goal(const std::shared_ptr<GoalHandle>& goal,
                                                            CancelCallback on_answer = {}) {
    return send_cancel(goal->get_goal_id(), {}, std::move(on_answer));
  }
  Future<std::shared_ptr<CancelResponse>> async_cancel_all_goals(CancelCallback on_answer = {}) {
    return send_cancel({}, {}, std::move(on_answer));
  }
  /// What was accepted at this time or before.
  Future<std::shared_ptr<CancelResponse>> async_cancel_goals_before(WallTime stamp, CancelCallback on_answer = {}) {
    return send_cancel({}, stamp, std::move(on_answer));
  }
  /// No callback for this goal starts any more.
  void stop_callbacks(const std::shared_ptr<GoalHandle>& goal) {
    const LockGuard lock(goal->mutex_);
    goal->on_feedback_ = nullptr;
    goal->on_result_.clear();
  }

 private:
  using SendGoal = typename A::Impl::SendGoalService;
  using GetResult = typename A::Impl::GetResultService;
  using CancelGoal = typename A::Impl::CancelGoalService;
  using FeedbackMessage = typename A::Impl::FeedbackMessage;
  using StatusMessage = typename A::Impl::GoalStatusMessage;

  template <typename T>
  Future<T> future_of(std::shared_future<T> future) const {
    return {std::move(future), [this] { return send_goal_->why_not_wait(); }};
  }
  std::shared_ptr<GoalHandle> take_answer(const GoalUUID& id, const typename SendGoal::Response* answer,
                                          const SendGoalOptions& options);
  void take_result(const std::shared_ptr<GoalHandle>& goal, const typename GetResult::Response* answer);
  void take_feedback(const std::shared_ptr<const FeedbackMessage>& message);
  void take_status(const StatusMessage& message);
  Future<std::shared_ptr<CancelResponse>> send_cancel(const GoalUUID& id, WallTime stamp, CancelCallback on_answer);
  [[nodiscard]] std::shared_ptr<GoalHandle> find(const GoalUUID& id) const;

  const std::string name_;
  mutable Mutex mutex_;
  std::map<GoalUUID, std::weak_ptr<GoalHandle>> goals_ NACELLE_GUARDED_BY(mutex_);  // that have not ended
  std::shared_ptr<nacelle::Client<SendGoal>> send_goal_;
  std::shared_ptr<nacelle::Client<CancelGoal>> cancel_goal_;
  std::shared_ptr<nacelle::Client<GetResult>> get_result_;
  std::shared_ptr<Subscription<FeedbackMessage>> feedback_;
  std::shared_ptr<Subscription<StatusMessage>> status_;
};

/// A client of the action `name` (relative, private or absolute; remaps apply to it as a whole).
template <typename A>
[[nodiscard]] std::shared_ptr<Client<A>> create_client(Node* node, const std::string& name,
                                                       const CallbackGroup::SharedPtr& group = nullptr) {
  return std::make_shared<Client<A>>(*node, name, group);
}

template <typename A>
Client<A>::Client(Node& node, const std::string& name, const CallbackGroup::SharedPtr& group)
    : name_(node.resolve_service_name(name)),
      send_goal_(node.create_client<SendGoal>(part_name(name_, kSendGoal), group)),
      cancel_goal_(node.create_client<CancelGoal>(part_name(name_, kCancelGoal), group)),
      get_result_(node.create_client<GetResult>(part_name(name_, kGetResult), group)) {
  SubscriptionOptions options;
  options.callback_group = group;
  feedback_ = node.create_subscription<FeedbackMessage>(
      part_name(name_, kFeedback), QoS(10),
      [this](const std::shared_ptr<const FeedbackMessage>& message) { take_feedback(message); }, options);
  status_ = node.create_subscription<StatusMessage>(
      part_name(name_, kStatus), QoS(1).transient_local(),
      [this](const StatusMessage& message) { take_status(message); }, options);
}

template <typename A>
bool Client<A>::wait_for_action_server(Duration timeout) const {
  // The graph does not report when a lifecycle gate opens, so this polls, as rclcpp does ten times a second.
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!action_server_is_ready()) {
    if (timeout >= Duration::zero() && std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

template <typename A>
std::shared_ptr<ClientGoalHandle<A>> Client<A>::find(const GoalUUID& id) const {
  const LockGuard lock(mutex_);
  const auto found = goals_.find(id);
  return found == goals_.end() ? nullptr : found->second.lock();
}

template <typename A>
Future<std::shared_ptr<ClientGoalHandle<A>>> Client<A>::async_send_goal(const Goal& goal, SendGoalOptions options) {
  auto promise = std::make_shared<std::promise<std::shared_ptr<GoalHandle>>>();
  auto future = future_of(promise->get_future().share());
  typename SendGoal::Request request{};
  const GoalUUID id = random_goal_id();
  request.goal_id.uuid = id;
  request.goal = goal;
  const auto answered = [this, id, promise, options = std::move(options)](const typename SendGoal::Response* answer) {
    auto handle = take_answer(id, answer, options);
    promise->set_value(handle);
    if (options.goal_response_callback) options.goal_response_callback(handle);
    if (handle && options.result_callback) async_get_result(handle, options.result_callback);
  };
  if (!send_goal_->async_send_request(std::move(request), answered)) answered(nullptr);
  return future;
}

template <typename A>
std::shared_ptr<ClientGoalHandle<A>> Client<A>::take_answer(const GoalUUID& id,
                                                            const typename SendGoal::Response* answer,
                                                            const SendGoalOptions& options) {
  if (answer == nullptr || !answer->accepted) return nullptr;
  auto handle = std::make_shared<GoalHandle>(id, time_of(answer->stamp), options.feedback_callback);
  const LockGuard lock(mutex_);
  std::erase_if(goals_, [](const auto& entry) { return entry.second.expired(); });
  goals_.emplace(id, handle);
  return handle;
}

template <typename A>
Future<typename ClientGoalHandle<A>::WrappedResult> Client<A>::async_get_result(const std::shared_ptr<GoalHandle>& goal,
                                                                                ResultCallback on_result) {
  auto future = future_of(goal->result_);
  bool is_there = false;
  bool ask = false;
  {
    const LockGuard lock(goal->mutex_);
    is_there = goal->result_.wait_for(Duration::zero()) == std::future_status::ready;
    if (!is_there && on_result) goal->on_result_.push_back(on_result);
    ask = !std::exchange(goal->asked_, true);
  }
  if (is_there && on_result) on_result(goal->result_.get());
  if (!ask) return future;
  typename GetResult::Request request{};
  request.goal_id.uuid = goal->get_goal_id();
  // The request keeps the handle, so that the result finds it.
  const auto answered = [this, goal](const typename GetResult::Response* answer) { take_result(goal, answer); };
  if (!get_result_->async_send_request(std::move(request), answered)) answered(nullptr);
  return future;
}

template <typename A>
void Client<A>::take_result(const std::shared_ptr<GoalHandle>& goal, const typename GetResult::Response* answer) {
  WrappedResult wrapped{goal->get_goal_id(), ResultCode::UNKNOWN, std::make_shared<typename A::Result>()};
  GoalStatus status = goal->get_status();
  if (answer != nullptr) {
    status = static_cast<GoalStatus>(answer->status);
    *wrapped.result = answer->result;
    goal->status_.store(status, std::memory_order_release);
  }
  // Without an answer: the server was deactivated before it was asked, and its status said how the goal ended.
  if (!is_active(status)) wrapped.code = static_cast<ResultCode>(status);
  {
    const LockGuard lock(mutex_);
    goals_.erase(goal->get_goal_id());
  }
  std::vector<ResultCallback> callbacks;
  {
    const LockGuard lock(goal->mutex_);
    goal->promise_.set_value(wrapped);
    callbacks.swap(goal->on_result_);
  }
  for (const auto& callback : callbacks) callback(wrapped);
}

template <typename A>
void Client<A>::take_feedback(const std::shared_ptr<const FeedbackMessage>& message) {
  const auto goal = find(message->goal_id.uuid);
  if (!goal) return;  // another client's
  FeedbackCallback callback;
  {
    const LockGuard lock(goal->mutex_);
    callback = goal->on_feedback_;
  }
  if (callback) callback(goal, std::shared_ptr<const typename A::Feedback>(message, &message->feedback));
}

template <typename A>
void Client<A>::take_status(const StatusMessage& message) {
  for (const auto& row : message.status_list) {
    const auto goal = find(row.goal_info.goal_id.uuid);
    if (!goal || !is_active(goal->get_status())) continue;
    goal->status_.store(static_cast<GoalStatus>(row.status), std::memory_order_release);
  }
}

template <typename A>
Future<std::shared_ptr<typename Client<A>::CancelResponse>> Client<A>::send_cancel(const GoalUUID& id, WallTime stamp,
                                                                                   CancelCallback on_answer) {
  auto promise = std::make_shared<std::promise<std::shared_ptr<CancelResponse>>>();
  auto future = future_of(promise->get_future().share());
  typename CancelGoal::Request request{};
  request.goal_info.goal_id.uuid = id;
  request.goal_info.stamp = stamp;
  const auto answered = [promise, on_answer = std::move(on_answer)](const CancelResponse* answer) {
    auto copy = answer != nullptr ? std::make_shared<CancelResponse>(*answer) : nullptr;
    promise->set_value(copy);
    if (on_answer) on_answer(copy);
  };
  if (!cancel_goal_->async_send_request(std::move(request), answered)) answered(nullptr);
  return future;
}

}  // namespace nacelle::action
