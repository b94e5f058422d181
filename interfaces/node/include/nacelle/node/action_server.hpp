// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "nacelle/host/action_names.hpp"
#include "nacelle/node/goal_keeper.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::action {

/// One accepted goal, for the component that works on it.
///
/// A goal whose last handle goes before it has ended ends as canceled.
/// Threads: any; several handles of one server may be used at the same time.
/// Errors:  IllegalTransition for what the goal's status does not allow. A false return is no mistake of the caller: the node was
///          deactivated or unloaded meanwhile, which aborts its goals; stop working on it.
template <typename A>
class ServerGoalHandle final {
 public:
  using SharedPtr = std::shared_ptr<ServerGoalHandle>;
  using Goal = typename A::Goal;
  using Result = typename A::Result;
  using Feedback = typename A::Feedback;

  ServerGoalHandle(std::shared_ptr<detail::GoalKeeper> keeper, const GoalUUID& id, std::shared_ptr<const Goal> goal)
      : keeper_(std::move(keeper)), id_(id), goal_(std::move(goal)) {}
  ~ServerGoalHandle() { keeper_->forsake(id_); }
  ServerGoalHandle(const ServerGoalHandle&) = delete;
  ServerGoalHandle& operator=(const ServerGoalHandle&) = delete;

  [[nodiscard]] std::shared_ptr<const Goal> get_goal() const { return goal_; }
  [[nodiscard]] const GoalUUID& get_goal_id() const { return id_; }
  /// A request to cancel was accepted: end it with canceled(), or with succeed() or abort() if it is too late for that.
  [[nodiscard]] bool is_canceling() const { return keeper_->status_of(id_) == GoalStatus::Canceling; }
  [[nodiscard]] bool is_executing() const { return keeper_->status_of(id_) == GoalStatus::Executing; }
  /// It has not ended. False at once when the node is deactivated.
  [[nodiscard]] bool is_active() const { return action::is_active(keeper_->status_of(id_)); }

  /// Begins a goal that was accepted with ACCEPT_AND_DEFER.
  bool execute() { return keeper_->execute(id_); }
  bool publish_feedback(const Feedback& feedback) { return keeper_->feedback(id_, &feedback); }
  bool publish_feedback(const std::shared_ptr<Feedback>& feedback) { return keeper_->feedback(id_, feedback.get()); }
  bool succeed(std::shared_ptr<Result> result) { return keeper_->end(id_, GoalEvent::Succeed, std::move(result)); }
  bool abort(std::shared_ptr<Result> result) { return keeper_->end(id_, GoalEvent::Abort, std::move(result)); }
  bool canceled(std::shared_ptr<Result> result) { return keeper_->end(id_, GoalEvent::Canceled, std::move(result)); }

 private:
  const std::shared_ptr<detail::GoalKeeper> keeper_;
  const GoalUUID id_;
  const std::shared_ptr<const Goal> goal_;
};

/// Offers one action; see create_server().
///
/// The three callbacks run on the node's executor, in the server's callback group. handle_accepted must not take long: it keeps
/// the goal handle and leaves the work to a timer, or to a thread that the component joins.
///
/// When the node is deactivated, faulted or unloaded, its goals are aborted, and clients that wait for results get that status.
/// An inactive node accepts no goal. A client that disappears does not end its goals.
/// Ownership: the component's, which it does not outlive.
template <typename A>
class Server final : private detail::GoalOutlets {
 public:
  using SharedPtr = std::shared_ptr<Server>;
  using Goal = typename A::Goal;
  using GoalHandle = ServerGoalHandle<A>;
  using GoalCallback = std::function<GoalResponse(const GoalUUID&, std::shared_ptr<const Goal>)>;
  using CancelCallback = std::function<CancelResponse(std::shared_ptr<GoalHandle>)>;
  using AcceptedCallback = std::function<void(std::shared_ptr<GoalHandle>)>;

  Server(Node& node, const std::string& name, GoalCallback handle_goal, CancelCallback handle_cancel,
         AcceptedCallback handle_accepted, const ServerOptions& options, const CallbackGroup::SharedPtr& group);
  ~Server() override {
    node_.remove_gate_listener(*keeper_);
    keeper_->close();
  }

  /// After expansion and remapping: "/fibonacci".
  [[nodiscard]] const std::string& get_action_name() const { return name_; }

 private:
  using SendGoal = typename A::Impl::SendGoalService;
  using GetResult = typename A::Impl::GetResultService;
  using CancelGoal = typename A::Impl::CancelGoalService;
  using FeedbackMessage = typename A::Impl::FeedbackMessage;
  using StatusMessage = typename A::Impl::GoalStatusMessage;

  void take_goal(const RequestId& request, const typename SendGoal::Request& asked);
  void take_cancel(const typename CancelGoal::Request& asked, typename CancelGoal::Response& answer);
  void make_timer(const ServerOptions& options, const CallbackGroup::SharedPtr& group);

  void publish_status(const std::vector<GoalTable::Goal>& goals) override;
  void publish_feedback(const GoalUUID& id, const void* feedback) override;
  void answer_result(const RequestId& request, GoalStatus status, const void* result) override;
  void watch_results(bool any) override;

  Node& node_;
  const std::string name_;
  const GoalCallback handle_goal_;
  const CancelCallback handle_cancel_;
  const AcceptedCallback handle_accepted_;
  const std::shared_ptr<detail::GoalKeeper> keeper_;
  std::shared_ptr<Publisher<FeedbackMessage>> feedback_;
  std::shared_ptr<Publisher<StatusMessage>> status_;
  std::shared_ptr<Timer> dropping_;  // null: results stay
  std::shared_ptr<Service<SendGoal>> send_goal_;
  std::shared_ptr<Service<CancelGoal>> cancel_goal_;
  std::shared_ptr<Service<GetResult>> get_result_;
};

/// Offers the action `name` (relative, private or absolute; remaps apply to it as a whole). In the constructor of a component.
///
/// `handle_goal` decides whether a goal is taken, `handle_cancel` whether one may be canceled, and `handle_accepted` gets the
/// handle of a goal that was taken. QoS: services reliable; feedback the last 10, reliable; status the last one, transient_local.
template <typename A>
[[nodiscard]] std::shared_ptr<Server<A>> create_server(Node* node, const std::string& name,
                                                       typename Server<A>::GoalCallback handle_goal,
                                                       typename Server<A>::CancelCallback handle_cancel,
                                                       typename Server<A>::AcceptedCallback handle_accepted,
                                                       const ServerOptions& options = {},
                                                       const CallbackGroup::SharedPtr& group = nullptr) {
  return std::make_shared<Server<A>>(*node, name, std::move(handle_goal), std::move(handle_cancel),
                                     std::move(handle_accepted), options, group);
}

template <typename A>
Server<A>::Server(Node& node, const std::string& name, GoalCallback handle_goal, CancelCallback handle_cancel,
                  AcceptedCallback handle_accepted, const ServerOptions& options, const CallbackGroup::SharedPtr& group)
    : node_(node),
      name_(node.resolve_service_name(name)),
      handle_goal_(std::move(handle_goal)),
      handle_cancel_(std::move(handle_cancel)),
      handle_accepted_(std::move(handle_accepted)),
      keeper_(
          std::make_shared<detail::GoalKeeper>(static_cast<detail::GoalOutlets&>(*this), node.steady_clock(), options)),
      feedback_(node.create_publisher<FeedbackMessage>(part_name(name_, kFeedback), QoS(10))),
      status_(node.create_publisher<StatusMessage>(part_name(name_, kStatus), QoS(1).transient_local())) {
  make_timer(options, group);
  // Services come last: a client that discovers the server can use all of it.
  get_result_ = node.create_service<GetResult>(
      part_name(name_, kGetResult),
      [this](const RequestId& request, const typename GetResult::Request& asked) {
        keeper_->request_result(asked.goal_id.uuid, request);
      },
      group);
  cancel_goal_ = node.create_service<CancelGoal>(
      part_name(name_, kCancelGoal),
      [this](const typename CancelGoal::Request& asked, typename CancelGoal::Response& answer) {
        take_cancel(asked, answer);
      },
      group);
  send_goal_ = node.create_service<SendGoal>(
      part_name(name_, kSendGoal),
      [this](const RequestId& request, const typename SendGoal::Request& asked) { take_goal(request, asked); }, group);
  node_.add_gate_listener(*keeper_);
}

template <typename A>
void Server<A>::make_timer(const ServerOptions& options, const CallbackGroup::SharedPtr& group) {
  if (options.result_timeout < Duration::zero()) return;
  // Requests look at the time themselves; the timer only sees to it that results do not lie about for ever.
  const Duration period = std::clamp<Duration>(options.result_timeout / 4, 10ms, 1s);
  dropping_ = node_.create_wall_timer(
      period, [this] { keeper_->expire(); }, group);
  dropping_->cancel();
}

template <typename A>
void Server<A>::take_goal(const RequestId& request, const typename SendGoal::Request& asked) {
  typename SendGoal::Response answer{};
  const GoalUUID id = asked.goal_id.uuid;
  auto goal = std::make_shared<const Goal>(asked.goal);
  const GoalResponse response = handle_goal_(id, goal);
  bool accepted = response != GoalResponse::REJECT;
  const WallTime stamp = node_.now();
  if (accepted) {
    const auto noted = keeper_->accept(id, stamp, response == GoalResponse::ACCEPT_AND_EXECUTE);
    if (!noted) node_.get_logger().warn("action {}: {}", name_, noted.error().text());
    accepted = static_cast<bool>(noted);
  }
  answer.accepted = accepted;
  if (accepted) answer.stamp = stamp;
  std::shared_ptr<GoalHandle> handle;
  if (accepted) {
    handle = std::make_shared<GoalHandle>(keeper_, id, std::move(goal));
    keeper_->attach(id, handle);
  }
  // The client learns of its goal before it hears of the goal's status and feedback.
  send_goal_->send_response(request, std::move(answer));
  if (!accepted) return;
  keeper_->publish_status();
  handle_accepted_(std::move(handle));
}

template <typename A>
void Server<A>::take_cancel(const typename CancelGoal::Request& asked, typename CancelGoal::Response& answer) {
  const auto choice = keeper_->choose(asked.goal_info.goal_id.uuid, time_of(asked.goal_info.stamp));
  answer = {};
  answer.return_code = static_cast<std::int8_t>(choice.code);
  for (const GoalUUID& id : choice.goals) {
    auto handle = std::static_pointer_cast<GoalHandle>(keeper_->handle_of(id));
    if (!handle || handle_cancel_(handle) != CancelResponse::ACCEPT || !keeper_->cancel(id)) continue;
    auto& canceling = answer.goals_canceling.emplace_back();
    canceling.goal_id.uuid = id;
    canceling.stamp = keeper_->accepted_at(id);
  }
  if (!answer.goals_canceling.empty()) {
    keeper_->publish_status();
  } else if (!choice.goals.empty()) {
    answer.return_code = static_cast<std::int8_t>(GoalTable::CancelCode::Rejected);
  }
}

template <typename A>
void Server<A>::publish_status(const std::vector<GoalTable::Goal>& goals) {
  auto message = status_->borrow();
  if (!message) return;
  message->status_list.resize(goals.size());
  for (std::size_t i = 0; i < goals.size(); ++i) {
    auto& row = message->status_list[i];
    row.goal_info.goal_id.uuid = goals[i].id;
    row.goal_info.stamp = goals[i].accepted_at;
    row.status = static_cast<std::int8_t>(goals[i].status);
  }
  status_->publish(std::move(message));
}

template <typename A>
void Server<A>::publish_feedback(const GoalUUID& id, const void* feedback) {
  auto message = feedback_->borrow();
  if (!message) return;
  message->goal_id.uuid = id;
  message->feedback = *static_cast<const typename A::Feedback*>(feedback);
  feedback_->publish(std::move(message));
}

template <typename A>
void Server<A>::answer_result(const RequestId& request, GoalStatus status, const void* result) {
  typename GetResult::Response answer{};
  answer.status = static_cast<std::int8_t>(status);
  if (result != nullptr) answer.result = *static_cast<const typename A::Result*>(result);
  get_result_->send_response(request, std::move(answer));
}

template <typename A>
void Server<A>::watch_results(bool any) {
  if (!dropping_) return;
  if (!any) {
    dropping_->cancel();
  } else if (dropping_->is_canceled()) {
    dropping_->reset();
  }
}

}  // namespace nacelle::action
