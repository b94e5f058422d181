// SPDX-License-Identifier: Apache-2.0
// The server alone, on a recording host: what it answers and publishes, and when it forgets.
#include "nacelle/node/action_server.hpp"

#include <gtest/gtest.h>

#include <example_interfaces/action/fibonacci.hpp>

#include "support/recording_host.hpp"

namespace nacelle::action {
namespace {

using example_interfaces::action::Fibonacci;
using CancelGoal = Fibonacci::Impl::CancelGoalService;
using GetResult = Fibonacci::Impl::GetResultService;
using SendGoal = Fibonacci::Impl::SendGoalService;
using StatusArray = Fibonacci::Impl::GoalStatusMessage;

/// Takes goals of an even order, and executes at once those below 100.
class Offering final : public LifecycleNode {
 public:
  explicit Offering(const NodeOptions& options, const ServerOptions& server_options = {})
      : LifecycleNode("offering", options) {
    server_ = create_server<Fibonacci>(
        this, "fibonacci",
        [](const GoalUUID&, const std::shared_ptr<const Fibonacci::Goal>& goal) {
          if (goal->order % 2 != 0) return GoalResponse::REJECT;
          return goal->order < 100 ? GoalResponse::ACCEPT_AND_EXECUTE : GoalResponse::ACCEPT_AND_DEFER;
        },
        [this](const auto&) { return cancel_response; }, [this](const auto& handle) { handles.push_back(handle); },
        server_options);
  }
  CancelResponse cancel_response = CancelResponse::ACCEPT;
  std::vector<std::shared_ptr<ServerGoalHandle<Fibonacci>>> handles;

 private:
  std::shared_ptr<Server<Fibonacci>> server_;
};

std::shared_ptr<Fibonacci::Result> result_of(std::initializer_list<std::int32_t> numbers) {
  auto result = std::make_shared<Fibonacci::Result>();
  result->sequence.assign(numbers.begin(), numbers.end());
  return result;
}

struct ActionServer : ::testing::Test {
  void SetUp() override {
    ASSERT_EQ(node.trigger(Transition::Configure).reason, "");
    ASSERT_EQ(node.trigger(Transition::Activate).reason, "");
  }
  bool send(std::uint8_t number, std::int32_t order) {
    SendGoal::Request request;
    request.goal_id.uuid[15] = number;
    request.goal.order = order;
    SendGoal::Response response;
    EXPECT_TRUE(context.call<SendGoal>("/fibonacci/_action/send_goal", request, response));
    return response.accepted;
  }
  /// Nothing: no answer yet.
  std::optional<GetResult::Response> result(std::uint8_t number) {
    GetResult::Request request;
    request.goal_id.uuid[15] = number;
    GetResult::Response response;
    if (!context.call<GetResult>("/fibonacci/_action/get_result", request, response)) return std::nullopt;
    return response;
  }
  CancelGoal::Response cancel(std::uint8_t number) {
    CancelGoal::Request request;
    request.goal_info.goal_id.uuid[15] = number;
    CancelGoal::Response response;
    EXPECT_TRUE(context.call<CancelGoal>("/fibonacci/_action/cancel_goal", request, response));
    return response;
  }
  /// Of the last message: goal number and status.
  std::vector<std::pair<int, int>> status() {
    const auto messages = context.published<StatusArray>("/fibonacci/_action/status");
    std::vector<std::pair<int, int>> rows;
    if (messages.empty()) return rows;
    for (const auto& row : messages.back().status_list) rows.emplace_back(row.goal_info.goal_id.uuid[15], row.status);
    return rows;
  }
  using Rows = std::vector<std::pair<int, int>>;

  test::RecordingContext context;
  Offering node{NodeOptions{context}};
};

TEST_F(ActionServer, says_of_each_goal_where_it_stands) {
  EXPECT_FALSE(send(1, 3));
  EXPECT_TRUE(send(2, 4));
  EXPECT_TRUE(send(3, 100));
  EXPECT_EQ(status(), (Rows{{2, 2}, {3, 1}}));
  ASSERT_EQ(node.handles.size(), 2U);
  EXPECT_TRUE(node.handles[0]->is_executing());
  EXPECT_FALSE(node.handles[1]->is_executing());
  node.handles[1]->execute();
  EXPECT_EQ(status(), (Rows{{2, 2}, {3, 2}}));
  node.handles[0]->succeed(result_of({1, 2}));
  EXPECT_EQ(status(), (Rows{{2, 4}, {3, 2}}));
  EXPECT_EQ(node.handles[0]->get_goal()->order, 4);
}

TEST_F(ActionServer, publishes_feedback_under_the_goals_id_until_it_ends) {
  ASSERT_TRUE(send(1, 4));
  Fibonacci::Feedback feedback;
  feedback.sequence = {1, 1, 2};
  EXPECT_TRUE(node.handles[0]->publish_feedback(feedback));
  node.handles[0]->succeed(result_of({}));
  EXPECT_FALSE(node.handles[0]->publish_feedback(feedback));
  const auto sent = context.published<Fibonacci::FeedbackMessage>("/fibonacci/_action/feedback");
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].goal_id.uuid[15], 1);
  EXPECT_EQ(sent[0].feedback, feedback);
}

TEST_F(ActionServer, keeps_a_result_for_ten_seconds) {
  ASSERT_TRUE(send(1, 4));
  EXPECT_FALSE(result(1)) << "the answer waits for the goal's end";
  node.handles[0]->succeed(result_of({1, 1, 2}));
  context.advance(9999ms);
  const auto there = result(1);
  ASSERT_TRUE(there);
  EXPECT_EQ(there->status, 4);
  EXPECT_EQ(there->result, *result_of({1, 1, 2}));
  context.advance(2ms);
  const auto gone = result(1);
  ASSERT_TRUE(gone);
  EXPECT_EQ(gone->status, 0) << "STATUS_UNKNOWN";
  EXPECT_EQ(gone->result, Fibonacci::Result{});
}

TEST_F(ActionServer, discards_results_after_the_timeout) {
  ASSERT_TRUE(send(1, 4));
  node.handles[0]->succeed(result_of({1}));
  std::weak_ptr<Fibonacci::Result> kept;
  ASSERT_TRUE(send(2, 4));
  {
    auto result = result_of({7});
    kept = result;
    node.handles[1]->succeed(std::move(result));
  }
  EXPECT_FALSE(kept.expired());
  context.advance(12s);
  EXPECT_TRUE(kept.expired()) << "the timer drops it, without a request";
}

TEST_F(ActionServer, answers_for_a_goal_that_it_never_had) { EXPECT_EQ(result(77)->status, 0); }

TEST_F(ActionServer, cancels_what_the_component_agrees_to) {
  ASSERT_TRUE(send(1, 4));
  node.cancel_response = CancelResponse::REJECT;
  auto answer = cancel(1);
  EXPECT_EQ(answer.return_code, 1) << "ERROR_REJECTED";
  EXPECT_TRUE(answer.goals_canceling.empty());
  EXPECT_FALSE(node.handles[0]->is_canceling());

  node.cancel_response = CancelResponse::ACCEPT;
  answer = cancel(1);
  EXPECT_EQ(answer.return_code, 0);
  ASSERT_EQ(answer.goals_canceling.size(), 1U);
  EXPECT_EQ(answer.goals_canceling[0].goal_id.uuid[15], 1);
  EXPECT_TRUE(node.handles[0]->is_canceling());
  EXPECT_TRUE(node.handles[0]->is_active());
  EXPECT_EQ(status(), (Rows{{1, 3}}));

  node.handles[0]->canceled(result_of({5}));
  EXPECT_EQ(result(1)->status, 5);
  EXPECT_EQ(cancel(1).return_code, 3) << "ERROR_GOAL_TERMINATED";
  EXPECT_EQ(cancel(9).return_code, 2) << "ERROR_UNKNOWN_GOAL_ID";
}

TEST_F(ActionServer, refuses_what_a_goals_status_does_not_allow) {
  ASSERT_TRUE(send(1, 4));
  EXPECT_THROW(node.handles[0]->canceled(result_of({})), IllegalTransition);
  EXPECT_THROW(node.handles[0]->execute(), IllegalTransition);
  EXPECT_TRUE(node.handles[0]->abort(result_of({})));
  try {
    node.handles[0]->succeed(result_of({}));
    FAIL() << "a goal ended twice";
  } catch (const IllegalTransition& e) {
    EXPECT_STREQ(e.what(), "goal 00000000000000000000000000000001: cannot succeed while it is ABORTED; it has ended");
  }
  EXPECT_EQ(result(1)->status, 6);
}

TEST_F(ActionServer, takes_an_id_once) {
  ASSERT_TRUE(send(1, 4));
  EXPECT_FALSE(send(1, 4));
  EXPECT_EQ(status(), (Rows{{1, 2}}));
  EXPECT_TRUE(node.handles[0]->is_executing()) << "the second goal's end is not the first one's";
}

TEST_F(ActionServer, ends_a_goal_whose_handle_is_dropped_as_canceled) {
  ASSERT_TRUE(send(1, 4));
  node.handles.clear();
  EXPECT_EQ(status(), (Rows{{1, 5}}));
  EXPECT_EQ(result(1)->status, 5);
}

TEST_F(ActionServer, aborts_its_goals_while_the_gate_is_still_open_when_the_node_is_deactivated) {
  ASSERT_TRUE(send(1, 4));
  ASSERT_TRUE(send(2, 100));
  ASSERT_EQ(node.trigger(Transition::Deactivate).reason, "");
  EXPECT_EQ(status(), (Rows{{1, 6}, {2, 6}})) << "the status got out";
  EXPECT_FALSE(node.handles[0]->is_active());
  EXPECT_FALSE(node.handles[0]->succeed(result_of({}))) << "too late, and no mistake of the component";
  EXPECT_FALSE(node.handles[1]->execute());

  ASSERT_EQ(node.trigger(Transition::Activate).reason, "");
  EXPECT_EQ(result(1)->status, 6);
  context.advance(12s);
  EXPECT_EQ(result(1)->status, 0);
  EXPECT_FALSE(node.handles[0]->succeed(result_of({}))) << "however late";
}

TEST_F(ActionServer, leaves_goal_handles_that_outlive_it_without_effect) {
  test::RecordingContext other;
  std::shared_ptr<ServerGoalHandle<Fibonacci>> handle;
  {
    Offering short_lived{NodeOptions{other}};
    short_lived.trigger(Transition::Configure);
    short_lived.trigger(Transition::Activate);
    SendGoal::Request request;
    request.goal.order = 4;
    SendGoal::Response response;
    ASSERT_TRUE(other.call<SendGoal>("/fibonacci/_action/send_goal", request, response));
    handle = short_lived.handles.at(0);
  }
  EXPECT_FALSE(handle->is_active());
  EXPECT_FALSE(handle->publish_feedback(Fibonacci::Feedback{}));
  EXPECT_FALSE(handle->succeed(result_of({})));
}

TEST(ActionServerName, is_remapped_as_a_whole) {
  test::RecordingContext context;
  Offering node{NodeOptions{context}.remap_rules({parse_remap_rule("fibonacci:=/arm/series").value()})};
  node.trigger(Transition::Configure);
  node.trigger(Transition::Activate);
  SendGoal::Response response;
  EXPECT_TRUE(context.call<SendGoal>("/arm/series/_action/send_goal", {}, response));
}

}  // namespace
}  // namespace nacelle::action
