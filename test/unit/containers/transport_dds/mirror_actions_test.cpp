// SPDX-License-Identifier: Apache-2.0
// An action between two containers that only the network joins: three services and two topics.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <example_interfaces/action/fibonacci.hpp>

#include "mirrored_container.hpp"
#include "nacelle/node/action_client.hpp"
#include "nacelle/node/action_server.hpp"

namespace nacelle {
namespace {

using action::CancelResponse;
using action::GoalResponse;
using action::GoalStatus;
using action::ResultCode;
using example_interfaces::action::Fibonacci;
using test::MirroredContainer;
using ServerHandle = action::ServerGoalHandle<Fibonacci>;
using ActionClient = action::Client<Fibonacci>;

/// Offers /fibonacci; hands each goal to the test. Negative orders are rejected.
class OfferingAction final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    return action::create_server<Fibonacci>(
        &node, "/fibonacci",
        [](const action::GoalUUID&, const std::shared_ptr<const Fibonacci::Goal>& asked) {
          return asked->order < 0 ? GoalResponse::REJECT : GoalResponse::ACCEPT_AND_EXECUTE;
        },
        [](const std::shared_ptr<ServerHandle>&) { return CancelResponse::ACCEPT; },
        [this](std::shared_ptr<ServerHandle> handle) { *goal.lock() = std::move(handle); });
  }
  Guarded<std::shared_ptr<ServerHandle>> goal;
};

class CallingAction final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    auto made = action::create_client<Fibonacci>(&node, "/fibonacci");
    client = made.get();
    return made;
  }
  ActionClient* client = nullptr;
};

class MirrorActions : public ::testing::Test {
 public:
  void SetUp() override {
    server_id = there.load(offering, "offering");
    here.load(calling, "calling");
    ASSERT_TRUE(calling.client->wait_for_action_server(30s));
  }
  template <typename F>
  [[nodiscard]] bool until(F holds) {
    return here.bell.until(holds);
  }
  template <typename T>
  static T value_of(const action::Future<T>& future) {
    EXPECT_EQ(future.wait_for(30s), std::future_status::ready);
    return future.get();
  }
  static Fibonacci::Goal goal_of(std::int32_t order) {
    Fibonacci::Goal goal;
    goal.order = order;
    return goal;
  }
  static std::shared_ptr<Fibonacci::Result> result_of(std::initializer_list<std::int32_t> numbers) {
    auto result = std::make_shared<Fibonacci::Result>();
    result->sequence.assign(numbers.begin(), numbers.end());
    return result;
  }
  /// The server's side of the goal that was accepted last.
  [[nodiscard]] std::shared_ptr<ServerHandle> served() {
    std::shared_ptr<ServerHandle> handle;
    EXPECT_TRUE(until([&] { return (handle = *offering.goal.lock()) != nullptr; }));
    return handle;
  }

  OfferingAction offering;
  CallingAction calling;
  MirroredContainer here{"here"}, there{"there"};
  std::uint64_t server_id = 0;
};

TEST_F(MirrorActions, go_from_goal_over_status_and_feedback_to_result) {
  std::atomic<std::size_t> heard{0};
  ActionClient::SendGoalOptions options;
  options.feedback_callback = [&](const auto&, const std::shared_ptr<const Fibonacci::Feedback>& feedback) {
    heard = feedback->sequence.size();
  };
  const auto handle = value_of(calling.client->async_send_goal(goal_of(3), options));
  ASSERT_TRUE(handle);
  const auto goal = served();
  ASSERT_TRUE(goal);
  EXPECT_EQ(goal->get_goal()->order, 3);
  EXPECT_EQ(goal->get_goal_id(), handle->get_goal_id());
  EXPECT_TRUE(until([&] { return handle->get_status() == GoalStatus::Executing; })) << "published on the status topic";
  // The endpoints of the topic may match a moment after the services, so it is sent more than once.
  Fibonacci::Feedback feedback;
  feedback.sequence = {1, 1};
  EXPECT_TRUE(until([&] {
    goal->publish_feedback(feedback);
    return heard == 2;
  }));
  EXPECT_TRUE(goal->succeed(result_of({1, 1, 2, 3})));
  const auto result = value_of(calling.client->async_get_result(handle));
  EXPECT_EQ(result.code, ResultCode::SUCCEEDED);
  EXPECT_EQ(*result.result, *result_of({1, 1, 2, 3}));
  EXPECT_TRUE(until([&] { return handle->get_status() == GoalStatus::Succeeded; }));
  EXPECT_EQ(here.stats().problems + there.stats().problems, 0U);
}

TEST_F(MirrorActions, are_rejected) { EXPECT_EQ(value_of(calling.client->async_send_goal(goal_of(-1))), nullptr); }

TEST_F(MirrorActions, are_canceled) {
  const auto handle = value_of(calling.client->async_send_goal(goal_of(1)));
  const auto goal = served();
  ASSERT_TRUE(handle && goal);
  const auto result = calling.client->async_get_result(handle);
  const auto answer = value_of(calling.client->async_cancel_goal(handle));
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->goals_canceling.size(), 1U);
  EXPECT_EQ(answer->goals_canceling[0].goal_id.uuid, handle->get_goal_id());
  EXPECT_TRUE(goal->is_canceling());
  EXPECT_TRUE(goal->canceled(result_of({9})));
  EXPECT_EQ(value_of(result).code, ResultCode::CANCELED) << "asked for before there was one";
}

TEST_F(MirrorActions, are_aborted_when_their_server_goes) {
  const auto handle = value_of(calling.client->async_send_goal(goal_of(1)));
  ASSERT_TRUE(handle && served());
  const auto result = calling.client->async_get_result(handle);
  ASSERT_TRUE(until([&] { return there.stats().requests == 2; }));
  ASSERT_TRUE(there.container().unload(server_id));
  EXPECT_EQ(value_of(result).code, ResultCode::ABORTED);
  EXPECT_TRUE(until([&] { return !calling.client->action_server_is_ready(); }));
}

TEST_F(MirrorActions, end_all_waits_when_the_network_of_their_server_ends) {
  const auto handle = value_of(calling.client->async_send_goal(goal_of(1)));
  ASSERT_TRUE(handle && served());
  const auto result = calling.client->async_get_result(handle);
  ASSERT_TRUE(until([&] { return there.stats().requests == 2; }));
  there.mirror.reset();
  EXPECT_EQ(value_of(result).code, ResultCode::UNKNOWN) << "its goal goes on there";
}

}  // namespace
}  // namespace nacelle
