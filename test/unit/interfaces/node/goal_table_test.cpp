// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/goal_table.hpp"

#include <gtest/gtest.h>

#include "nacelle/host/action_names.hpp"

namespace nacelle::action {
namespace {

using Event = GoalEvent;
using Status = GoalStatus;

GoalUUID goal_id(std::uint8_t number) {
  GoalUUID id{};
  id[15] = number;
  return id;
}
constexpr MonotonicTime kStart{1000s};

struct GoalTableTest : ::testing::Test {
  void accept(std::uint8_t number, WallTime stamp = WallTime{1s}) {
    std::vector<GoalUUID> dropped;
    const auto accepted = table.accept(goal_id(number), stamp, dropped);
    ASSERT_TRUE(accepted) << accepted.error().text();
    EXPECT_TRUE(dropped.empty());
  }
  void apply(std::uint8_t number, std::initializer_list<Event> events, MonotonicTime at = kStart) {
    for (const Event event : events) ASSERT_TRUE(table.apply(goal_id(number), event, at)) << to_text(event);
  }
  ServerOptions options{10s, 3};
  GoalTable table{options};
};

TEST(GoalStateMachine, allows_what_the_one_of_rcl_allows_and_nothing_else) {
  struct Edge {
    Status from;
    Event event;
    Status to;
  };
  const Edge allowed[] = {
      {Status::Accepted, Event::Execute, Status::Executing},
      {Status::Accepted, Event::CancelGoal, Status::Canceling},
      {Status::Executing, Event::CancelGoal, Status::Canceling},
      {Status::Executing, Event::Succeed, Status::Succeeded},
      {Status::Executing, Event::Abort, Status::Aborted},
      {Status::Canceling, Event::Succeed, Status::Succeeded},
      {Status::Canceling, Event::Abort, Status::Aborted},
      {Status::Canceling, Event::Canceled, Status::Canceled},
  };
  std::size_t found = 0;
  for (int from = 0; from <= 6; ++from) {
    for (const Event event : {Event::Execute, Event::CancelGoal, Event::Succeed, Event::Abort, Event::Canceled}) {
      const auto to = next_status(static_cast<Status>(from), event);
      if (!to) continue;
      ++found;
      const bool is_listed = std::any_of(std::begin(allowed), std::end(allowed), [&](const Edge& edge) {
        return edge.from == static_cast<Status>(from) && edge.event == event && edge.to == *to;
      });
      EXPECT_TRUE(is_listed) << to_text(static_cast<Status>(from)) << " " << to_text(event);
    }
  }
  EXPECT_EQ(found, std::size(allowed));
}

TEST_F(GoalTableTest, refuses_an_illegal_transition_with_goal_wish_and_status_and_changes_nothing) {
  accept(1);
  const auto refused = table.apply(goal_id(1), Event::Succeed, kStart);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text(), "goal 00000000000000000000000000000001: cannot succeed while it is ACCEPTED");
  EXPECT_EQ(table.status_of(goal_id(1)), Status::Accepted);

  apply(1, {Event::Execute, Event::Succeed});
  EXPECT_EQ(table.apply(goal_id(1), Event::Abort, kStart).error().what, "cannot abort while it is SUCCEEDED");
  EXPECT_EQ(table.apply(goal_id(9), Event::Abort, kStart).error().what, "is not known");
}

TEST_F(GoalTableTest, takes_an_id_once) {
  accept(1);
  std::vector<GoalUUID> dropped;
  EXPECT_EQ(table.accept(goal_id(1), WallTime{}, dropped).error().what, "this id is taken already");
  EXPECT_EQ(table.goals().size(), 1U);
}

TEST_F(GoalTableTest, is_bounded_the_oldest_result_makes_room_an_active_goal_never) {
  for (const std::uint8_t number : {1, 2, 3}) accept(number);
  std::vector<GoalUUID> dropped;
  EXPECT_EQ(table.accept(goal_id(4), WallTime{}, dropped).error().what, "3 goals are active already");

  apply(2, {Event::Execute, Event::Succeed}, kStart + 2s);
  apply(3, {Event::Execute, Event::Succeed}, kStart + 1s);
  ASSERT_TRUE(table.accept(goal_id(4), WallTime{}, dropped));
  EXPECT_EQ(dropped, std::vector<GoalUUID>{goal_id(3)});
  EXPECT_EQ(table.status_of(goal_id(3)), Status::Unknown);
  EXPECT_EQ(table.status_of(goal_id(2)), Status::Succeeded);
}

TEST_F(GoalTableTest, drops_a_result_once_the_timeout_has_passed_since_the_goals_end) {
  accept(1);
  accept(2);
  apply(1, {Event::Execute, Event::Succeed}, kStart);
  EXPECT_TRUE(table.expire(kStart + 10s).empty());
  EXPECT_EQ(table.expire(kStart + 10s + 1ns), std::vector<GoalUUID>{goal_id(1)});
  EXPECT_EQ(table.status_of(goal_id(1)), Status::Unknown);
  EXPECT_TRUE(table.expire(kStart + 1000s).empty()) << "an active goal does not expire";
}

TEST(GoalTable, keeps_results_for_ever_with_a_negative_timeout_and_hardly_at_all_with_zero) {
  for (const Duration timeout : {Duration{-1}, Duration{0}}) {
    GoalTable table{{timeout, 3}};
    std::vector<GoalUUID> dropped;
    ASSERT_TRUE(table.accept(goal_id(1), WallTime{}, dropped));
    ASSERT_TRUE(table.apply(goal_id(1), Event::Execute, kStart));
    ASSERT_TRUE(table.apply(goal_id(1), Event::Abort, kStart));
    EXPECT_TRUE(table.holds_results());
    EXPECT_EQ(table.expire(kStart + 1ns).size(), timeout == Duration{0} ? 1U : 0U);
  }
}

TEST_F(GoalTableTest, aborts_whatever_is_active_also_what_was_never_executed) {
  for (const std::uint8_t number : {1, 2, 3}) accept(number);
  apply(1, {Event::Execute, Event::Succeed});
  apply(2, {Event::Execute, Event::CancelGoal});
  EXPECT_EQ(table.abort_all(kStart), (std::vector<GoalUUID>{goal_id(2), goal_id(3)}));
  EXPECT_EQ(table.status_of(goal_id(1)), Status::Succeeded);
  EXPECT_EQ(table.status_of(goal_id(2)), Status::Aborted);
  EXPECT_EQ(table.status_of(goal_id(3)), Status::Aborted);
}

TEST_F(GoalTableTest, chooses_the_goals_to_cancel_as_specified_by_cancel_goal_srv) {
  accept(1, WallTime{10s});
  accept(2, WallTime{20s});
  accept(3, WallTime{30s});
  const GoalUUID nobody{};
  EXPECT_EQ(table.choose(nobody, {}).goals.size(), 3U);
  EXPECT_EQ(table.choose(nobody, WallTime{20s}).goals, (std::vector<GoalUUID>{goal_id(1), goal_id(2)}));
  EXPECT_EQ(table.choose(goal_id(3), WallTime{10s}).goals, (std::vector<GoalUUID>{goal_id(1), goal_id(3)}));
  EXPECT_EQ(table.choose(goal_id(2), {}).goals, std::vector<GoalUUID>{goal_id(2)});
  EXPECT_EQ(table.choose(goal_id(9), {}).code, GoalTable::CancelCode::UnknownGoalId);

  apply(2, {Event::Execute, Event::Succeed});
  EXPECT_EQ(table.choose(goal_id(2), {}).code, GoalTable::CancelCode::GoalTerminated);
  EXPECT_EQ(table.choose(nobody, {}).goals, (std::vector<GoalUUID>{goal_id(1), goal_id(3)}));
}

TEST(ActionNames, are_read_off_the_feedback_topic_alone) {
  const auto action =
      action_of_topic("/arm/fibonacci/_action/feedback", "example_interfaces/action/Fibonacci_FeedbackMessage");
  ASSERT_TRUE(action);
  EXPECT_EQ(action->name, "/arm/fibonacci");
  EXPECT_EQ(action->type, "example_interfaces/action/Fibonacci");
  EXPECT_FALSE(action_of_topic("/arm/fibonacci/_action/status", "action_msgs/msg/GoalStatusArray"));
  EXPECT_FALSE(action_of_topic("/feedback", "example_interfaces/action/Fibonacci_FeedbackMessage"));
  EXPECT_TRUE(is_action_part("/fibonacci/_action/send_goal"));
  EXPECT_FALSE(is_action_part("/fibonacci/action"));
}

TEST(GoalUUID, is_random_and_written_as_32_digits) {
  const GoalUUID one = random_goal_id(), other = random_goal_id();
  EXPECT_NE(one, other);
  EXPECT_EQ(to_string(one).size(), 32U);
  EXPECT_EQ(to_string(goal_id(0xab)), "000000000000000000000000000000ab");
}

}  // namespace
}  // namespace nacelle::action
