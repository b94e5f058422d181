// SPDX-License-Identifier: Apache-2.0
// Actions between components: the whole way from goal to result, and what happens when one side goes.
#include <gtest/gtest.h>

#include <bit>
#include <condition_variable>
#include <example_interfaces/action/fibonacci.hpp>
#include <std_srvs/srv/set_bool.hpp>
#include <thread>

#include "benchmark/support/recipe.hpp"
#include "nacelle/base/guarded.hpp"
#include "nacelle/node/action_client.hpp"
#include "nacelle/node/action_server.hpp"
#include "nacelle/runtime/container.hpp"
#include "support/places.hpp"

namespace nacelle::runtime {
namespace {

using action::CancelResponse;
using action::GoalResponse;
using action::GoalStatus;
using action::ResultCode;
using example_interfaces::action::Fibonacci;
using std_srvs::srv::SetBool;
using ServerHandle = action::ServerGoalHandle<Fibonacci>;
using Client = action::Client<Fibonacci>;
using ClientHandle = action::ClientGoalHandle<Fibonacci>;

std::shared_ptr<Fibonacci::Result> result_of(std::initializer_list<std::int32_t> numbers) {
  auto result = std::make_shared<Fibonacci::Result>();
  result->sequence.assign(numbers.begin(), numbers.end());
  return result;
}

/// What happened, in order; waits for more by event. Threads: any.
class Diary {
 public:
  void note(std::string what) {
    const std::lock_guard lock(mutex_);
    notes_.push_back(std::move(what));
    noted_.notify_all();
  }
  std::vector<std::string> wait_for(std::size_t count) {
    std::unique_lock lock(mutex_);
    noted_.wait_for(lock, 20s, [&] { return notes_.size() >= count; });
    return notes_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable noted_;
  std::vector<std::string> notes_;
};

/// Offers /fibonacci; hands each goal to the test. Negative orders are rejected.
class Offering final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    return action::create_server<Fibonacci>(
        &node, "/fibonacci",
        [](const action::GoalUUID&, const std::shared_ptr<const Fibonacci::Goal>& goal) {
          return goal->order < 0 ? GoalResponse::REJECT : GoalResponse::ACCEPT_AND_EXECUTE;
        },
        [](const std::shared_ptr<ServerHandle>&) { return CancelResponse::ACCEPT; },
        [this](std::shared_ptr<ServerHandle> handle) {
          if (at_once) at_once(*handle);
          const std::lock_guard lock(mutex_);
          handles_.push_back(std::move(handle));
          taken_.notify_all();
        });
  }
  std::shared_ptr<ServerHandle> next() {
    std::unique_lock lock(mutex_);
    if (!taken_.wait_for(lock, 20s, [&] { return !handles_.empty(); })) return nullptr;
    auto handle = handles_.front();
    handles_.erase(handles_.begin());
    return handle;
  }
  std::function<void(ServerHandle&)> at_once;

 private:
  std::mutex mutex_;
  std::condition_variable taken_;
  std::vector<std::shared_ptr<ServerHandle>> handles_;
};

/// Calls /fibonacci. The client is the component's; the test may use it while it is loaded.
class Asking final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    auto made = action::create_client<Fibonacci>(&node, "/fibonacci");
    client = made.get();
    return made;
  }
  Client::SendGoalOptions options() {
    return {[this](const std::shared_ptr<ClientHandle>& handle) { diary.note(handle ? "accepted" : "rejected"); },
            [this](const std::shared_ptr<ClientHandle>&, const std::shared_ptr<const Fibonacci::Feedback>& feedback) {
              diary.note("feedback " + std::to_string(feedback->sequence.size()));
            },
            [this](const Client::WrappedResult& result) {
              diary.note(std::string{"result "} + to_text(static_cast<GoalStatus>(result.code)) + " " +
                         std::to_string(result.result->sequence.size()));
            }};
  }
  Client* client = nullptr;
  Diary diary;
};

Fibonacci::Goal goal_of(std::int32_t order) {
  Fibonacci::Goal goal;
  goal.order = order;
  return goal;
}

class Actions : public ::testing::TestWithParam<bool> {
 public:
  static ContainerOptions with_plugins() {
    ContainerOptions options;
    options.component_path = {test::component_folder()};
    return options;
  }
  std::uint64_t load(bench::Recipe& recipe, const std::string& name, bool active = true, ThreadPolicy thread = {}) {
    LoadRequest request;
    request.plugin = "nacelle::bench::Part";
    request.name = name;
    request.thread = std::move(thread);
    request.parameters = {{"recipe", static_cast<std::int64_t>(std::bit_cast<std::intptr_t>(&recipe))}};
    const auto loaded = container_.load(request);
    EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().text());
    if (!loaded) return 0;
    EXPECT_EQ(container_.trigger(loaded.value().id, Transition::Configure).reason, "");
    if (active) { EXPECT_EQ(container_.trigger(loaded.value().id, Transition::Activate).reason, ""); }
    return loaded.value().id;
  }
  template <typename T>
  static T value_of(const action::Future<T>& future) {
    EXPECT_EQ(future.wait_for(20s), std::future_status::ready);
    return future.get();
  }
  using Notes = std::vector<std::string>;

  SystemClock clock_;
  Offering offering_;  // outlive their components
  Asking asking_, other_;
  Container container_{with_plugins(), clock_};
};

TEST_P(Actions, go_from_goal_over_feedback_to_result) {
  const ThreadPolicy thread{.own = GetParam()};
  offering_.at_once = [](ServerHandle& handle) {
    Fibonacci::Feedback feedback;
    for (int i = 0; i < handle.get_goal()->order; ++i) {
      feedback.sequence.push_back(i);
      handle.publish_feedback(feedback);
    }
  };
  load(offering_, "offering", true, thread);
  load(asking_, "asking", true, thread);
  load(other_, "other", true, thread);
  ASSERT_TRUE(asking_.client->wait_for_action_server(20s));

  const auto sent = asking_.client->async_send_goal(goal_of(3), asking_.options());
  const auto handle = value_of(sent);
  ASSERT_TRUE(handle);
  const Notes on_the_way{"accepted", "feedback 1", "feedback 2", "feedback 3"};
  EXPECT_EQ(asking_.diary.wait_for(4), on_the_way);
  offering_.next()->succeed(result_of({1, 1, 2, 3}));
  const auto result = value_of(asking_.client->async_get_result(handle));
  EXPECT_EQ(result.code, ResultCode::SUCCEEDED);
  EXPECT_EQ(result.goal_id, handle->get_goal_id());
  EXPECT_EQ(*result.result, *result_of({1, 1, 2, 3}));
  EXPECT_EQ(handle->get_status(), GoalStatus::Succeeded);
  EXPECT_EQ(asking_.diary.wait_for(5),
            (Notes{"accepted", "feedback 1", "feedback 2", "feedback 3", "result SUCCEEDED 4"}));
  EXPECT_TRUE(other_.diary.wait_for(0).empty()) << "another client hears nothing of it";
}
INSTANTIATE_TEST_SUITE_P(, Actions, ::testing::Bool(),
                         [](const auto& made) { return made.param ? "each_on_its_thread" : "on_one_thread"; });

TEST_F(Actions, are_rejected_by_the_server_and_where_there_is_none) {
  load(asking_, "asking");
  EXPECT_FALSE(asking_.client->action_server_is_ready());
  EXPECT_FALSE(asking_.client->wait_for_action_server(1ms));
  EXPECT_EQ(asking_.client->async_send_goal(goal_of(1), asking_.options()).get(), nullptr);
  EXPECT_EQ(asking_.diary.wait_for(1), Notes{"rejected"});

  const auto id = load(offering_, "offering", false);
  EXPECT_FALSE(asking_.client->action_server_is_ready()) << "it is not active";
  EXPECT_EQ(asking_.client->async_send_goal(goal_of(1)).get(), nullptr);
  EXPECT_EQ(container_.trigger(id, Transition::Activate).reason, "");
  ASSERT_TRUE(asking_.client->action_server_is_ready());
  EXPECT_EQ(value_of(asking_.client->async_send_goal(goal_of(-1), asking_.options())), nullptr);
  EXPECT_EQ(asking_.diary.wait_for(2), (Notes{"rejected", "rejected"}));
}

TEST_F(Actions, are_canceled_when_the_component_has_cleaned_up) {
  load(offering_, "offering");
  load(asking_, "asking");
  const auto handle = value_of(asking_.client->async_send_goal(goal_of(1), asking_.options()));
  const auto served = offering_.next();
  ASSERT_TRUE(handle && served);
  const auto answer = value_of(asking_.client->async_cancel_goal(handle));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->return_code, 0);
  ASSERT_EQ(answer->goals_canceling.size(), 1U);
  EXPECT_EQ(answer->goals_canceling[0].goal_id.uuid, handle->get_goal_id());
  EXPECT_TRUE(served->is_canceling());
  served->canceled(result_of({9}));
  EXPECT_EQ(value_of(asking_.client->async_get_result(handle)).code, ResultCode::CANCELED);
  EXPECT_EQ(asking_.diary.wait_for(2), (Notes{"accepted", "result CANCELED 1"}));
  EXPECT_EQ(value_of(asking_.client->async_cancel_goal(handle))->return_code, 3) << "it has ended";
}

TEST_F(Actions, can_be_canceled_all_at_once) {
  load(offering_, "offering");
  load(asking_, "asking");
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(value_of(asking_.client->async_send_goal(goal_of(i))));
  std::vector<std::shared_ptr<ServerHandle>> served;
  for (int i = 0; i < 3; ++i) served.push_back(offering_.next());
  EXPECT_EQ(value_of(asking_.client->async_cancel_all_goals())->goals_canceling.size(), 3U);
  for (const auto& handle : served) EXPECT_TRUE(handle->is_canceling());
}

TEST_F(Actions, are_aborted_when_their_server_is_deactivated) {
  const auto id = load(offering_, "offering");
  load(asking_, "asking");
  ASSERT_TRUE(value_of(asking_.client->async_send_goal(goal_of(1), asking_.options())));
  const auto served = offering_.next();
  ASSERT_TRUE(served);
  EXPECT_EQ(container_.trigger(id, Transition::Deactivate).reason, "");
  EXPECT_EQ(asking_.diary.wait_for(2), (Notes{"accepted", "result ABORTED 0"}));
  EXPECT_FALSE(served->is_active());
  EXPECT_FALSE(served->succeed(result_of({1})));
}

TEST_F(Actions, are_aborted_when_their_server_is_unloaded) {
  const auto id = load(offering_, "offering");
  load(asking_, "asking");
  ASSERT_TRUE(value_of(asking_.client->async_send_goal(goal_of(1), asking_.options())));
  const auto served = offering_.next();
  ASSERT_TRUE(served);
  ASSERT_TRUE(container_.unload(id));
  EXPECT_EQ(asking_.diary.wait_for(2), (Notes{"accepted", "result ABORTED 0"}));
  EXPECT_FALSE(served->succeed(result_of({1}))) << "a handle that outlives its server has no effect";
}

TEST_F(Actions, go_on_when_their_client_is_unloaded) {
  load(offering_, "offering");
  const auto id = load(asking_, "asking");
  ASSERT_TRUE(value_of(asking_.client->async_send_goal(goal_of(1), asking_.options())));
  const auto served = offering_.next();
  ASSERT_TRUE(served);
  ASSERT_TRUE(container_.unload(id));
  EXPECT_TRUE(served->is_executing());
  EXPECT_TRUE(served->publish_feedback(Fibonacci::Feedback{}));
  EXPECT_TRUE(served->succeed(result_of({1})));
  EXPECT_EQ(asking_.diary.wait_for(1), Notes{"accepted"}) << "no callback after the client";
}

TEST_F(Actions, end_on_any_thread_while_others_begin) {
  load(offering_, "offering", true, {.own = true});
  load(asking_, "asking", true, {.own = true});
  constexpr int kGoals = 40;
  std::vector<std::thread> workers;
  std::vector<action::Future<Client::WrappedResult>> results;
  for (int i = 0; i < kGoals; ++i) {
    const auto handle = value_of(asking_.client->async_send_goal(goal_of(i)));
    ASSERT_TRUE(handle);
    results.push_back(asking_.client->async_get_result(handle));
    workers.emplace_back([served = offering_.next()] {
      Fibonacci::Feedback feedback;
      for (int n = 0; n < 5; ++n) served->publish_feedback(feedback);
      served->succeed(result_of({served->get_goal()->order}));
    });
  }
  for (auto& worker : workers) worker.join();
  for (int i = 0; i < kGoals; ++i) {
    const auto result = value_of(results[static_cast<std::size_t>(i)]);
    EXPECT_EQ(result.code, ResultCode::SUCCEEDED);
    EXPECT_EQ(*result.result, *result_of({i}));
  }
}

TEST_F(Actions, end_on_their_own_thread_while_the_server_is_unloaded) {
  const auto id = load(offering_, "offering", true, {.own = true});
  load(asking_, "asking");
  ASSERT_TRUE(value_of(asking_.client->async_send_goal(goal_of(1), asking_.options())));
  std::atomic<bool> was_told = false;
  std::thread worker([&, served = offering_.next()] {
    Fibonacci::Feedback feedback;
    while (served->publish_feedback(feedback)) std::this_thread::yield();
    was_told = !served->succeed(result_of({}));
  });
  EXPECT_TRUE(container_.unload(id));
  worker.join();
  EXPECT_TRUE(was_told);
}

/// Waits for its own goal in a callback that keeps the answer away.
class Selfish final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    client_ = action::create_client<Fibonacci>(&node, "/fibonacci");
    return node.create_wall_timer(1ms, [this] {
      if (tried_) return;
      tried_ = true;
      try {
        static_cast<void>(client_->async_send_goal(goal_of(1)).get());
        diary.note("answered");
      } catch (const exceptions::WaitsForItself&) { diary.note("refused"); }
      client_.reset();
    });
  }
  Diary diary;

 private:
  bool tried_ = false;
  std::shared_ptr<Client> client_;
};

TEST_F(Actions, are_not_waited_for_where_that_would_never_end) {
  load(offering_, "offering");
  Selfish selfish;
  const auto id = load(selfish, "selfish", true);
  EXPECT_EQ(selfish.diary.wait_for(1), Notes{"refused"});
  EXPECT_TRUE(container_.unload(id));
}

/// A service that leaves its answers to the test.
class Slow final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    auto made = node.create_service<SetBool>("/slow", [this](const RequestId& request, const SetBool::Request&) {
      const std::lock_guard lock(mutex_);
      asked_.push_back(request);
      came_.notify_all();
    });
    service = made.get();
    return made;
  }
  RequestId next() {
    std::unique_lock lock(mutex_);
    if (!came_.wait_for(lock, 20s, [&] { return !asked_.empty(); })) return {};
    const RequestId request = asked_.front();
    asked_.erase(asked_.begin());
    return request;
  }
  Service<SetBool>* service = nullptr;

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::vector<RequestId> asked_;
};
class SlowCaller final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    auto made = node.create_client<SetBool>("/slow");
    client = made.get();
    return made;
  }
  void call() {
    EXPECT_TRUE(client->async_send_request(
        {}, [this](const SetBool::Response* response) { diary.note(response ? response->message : "none"); }));
  }
  nacelle::Client<SetBool>* client = nullptr;
  Diary diary;
};

TEST_F(Actions, rest_on_services_that_answer_later_in_any_order_and_once) {
  Slow slow;
  SlowCaller caller;
  const auto id = load(slow, "slow");
  const auto caller_id = load(caller, "caller");
  for (int i = 0; i < 3; ++i) caller.call();
  const RequestId first = slow.next(), second = slow.next(), third = slow.next();
  SetBool::Response answer;
  answer.message = "second";
  EXPECT_TRUE(slow.service->send_response(second, answer));
  EXPECT_FALSE(slow.service->send_response(second, answer)) << "a request is answered once";
  answer.message = "first";
  EXPECT_TRUE(slow.service->send_response(first, answer));
  EXPECT_EQ(caller.diary.wait_for(2), (Notes{"second", "first"}));
  caller.call();
  const RequestId fourth = slow.next();
  ASSERT_TRUE(container_.unload(id));
  EXPECT_EQ(caller.diary.wait_for(4), (Notes{"second", "first", "none", "none"}))
      << "calls still open when the service ends: " << third.sequence_number << ", " << fourth.sequence_number;
  EXPECT_TRUE(container_.unload(caller_id));
}

}  // namespace
}  // namespace nacelle::runtime
