// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/callback_group.hpp"

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "executor_fixture.hpp"
#include "nacelle/runtime/timer_queue.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::runtime {
namespace {

ThreadPolicy threads(std::uint32_t n) { return {.own = true, .priority = 0, .cpus = {}, .threads = n}; }

struct GroupsTest : ::testing::Test {
  SystemClock clock;
  Executor executor{"groups", clock, threads(3)};
  NodeGroups node{executor, "/node", [](const auto&...) {}};
  CallbackGroup one{node}, two{node}, reentrant{node, CallbackGroupType::Reentrant};
  void SetUp() override { executor.open(node); }
};

TEST_F(GroupsTest, callbacks_of_different_groups_of_a_node_overlap) {
  Meeting meeting;
  std::atomic<int> met{0};
  Callable first(one, [&] { met += meeting.meet() ? 1 : 0; });
  Callable second(two, [&] { met += meeting.meet() ? 1 : 0; });
  executor.post(first);
  executor.post(second);
  drain(one);
  drain(two);
  EXPECT_EQ(met, 2);
}

TEST_F(GroupsTest, callbacks_of_a_reentrant_group_overlap) {
  Meeting meeting;
  std::atomic<int> met{0};
  Callable first(reentrant, [&] { met += meeting.meet() ? 1 : 0; });
  Callable second(reentrant, [&] { met += meeting.meet() ? 1 : 0; });
  executor.post(first);
  executor.post(second);
  while (met < 2) drain(reentrant);
}

TEST_F(GroupsTest, a_callback_of_a_reentrant_group_overlaps_itself) {
  Meeting meeting;
  std::atomic<int> met{0};
  Door entered;
  Callable self(reentrant, [&] {
    entered.open();
    met += meeting.meet() ? 1 : 0;
  });
  executor.post(self);
  ASSERT_TRUE(entered.wait());
  executor.post(self);
  while (met < 2) drain(reentrant);
}

TEST_F(GroupsTest, callbacks_of_a_mutually_exclusive_group_never_overlap) {
  std::atomic<int> inside{0}, runs{0}, most{0};
  std::vector<std::unique_ptr<Callable>> all;
  for (int i = 0; i < 4; ++i) {
    all.push_back(std::make_unique<Callable>(one, [&] {
      most = std::max(most.load(), ++inside);
      ++runs;
      --inside;
    }));
    all.back()->again = [&] { return runs < 20000; };
  }
  for (const auto& callable : all) executor.post(*callable);
  while (runs < 20000) drain(one);
  EXPECT_EQ(most, 1);
}

TEST_F(GroupsTest, on_one_thread_a_reentrant_group_changes_nothing) {
  Executor single{"single", clock, threads(1)};
  NodeGroups other{single, "/other", [](const auto&...) {}};
  single.open(other);
  CallbackGroup group{other, CallbackGroupType::Reentrant};
  std::atomic<int> inside{0}, most{0}, runs{0};
  const auto run = [&] {
    most = std::max(most.load(), ++inside);
    ++runs;
    --inside;
  };
  Callable first(group, run), second(group, run);
  first.again = second.again = [&] { return runs < 1000; };
  single.post(first);
  single.post(second);
  while (runs < 1000) drain(group);
  EXPECT_EQ(most, 1);
}

TEST_F(GroupsTest, a_transition_waits_for_all_groups_and_nothing_starts_beside_it) {
  Door entered[2], release[2], in_transition, end_transition;
  std::atomic<int> inside{0}, beside{-1};
  std::atomic<bool> later_ran{false};
  const auto hold = [&](int i) {
    ++inside;
    entered[i].open();
    EXPECT_TRUE(release[i].wait());
    --inside;
  };
  Callable first(one, [&] { hold(0); }), second(reentrant, [&] { hold(1); });
  Callable transition(
      one,
      [&] {
        beside = inside.load();
        in_transition.open();
        EXPECT_TRUE(end_transition.wait());
      },
      Executable::Kind::Transition);
  Callable later(two, [&] { later_ran = true; });
  executor.post(first);
  executor.post(second);
  ASSERT_TRUE(entered[0].wait());
  ASSERT_TRUE(entered[1].wait());

  executor.post(transition);
  NodeGroups passer_by{executor, "/passer_by", [](const auto&...) {}};
  CallbackGroup their{passer_by};
  executor.open(passer_by);
  drain(their);  // the third thread has seen the transition by now
  executor.post(later);
  drain(their);
  EXPECT_FALSE(later_ran) << "a transition that waits is not overtaken";
  release[0].open();
  drain(their);
  EXPECT_EQ(beside, -1) << "the other group still runs";
  release[1].open();
  ASSERT_TRUE(in_transition.wait());
  EXPECT_EQ(beside, 0);
  drain(their);
  EXPECT_FALSE(later_ran);
  end_transition.open();
  drain(two);
  EXPECT_TRUE(later_ran);
}

TEST_F(GroupsTest, closing_waits_for_all_groups) {
  Door entered[2], release[2];
  Callable first(one, [&] {
    entered[0].open();
    EXPECT_TRUE(release[0].wait());
  });
  Callable second(reentrant, [&] {
    entered[1].open();
    EXPECT_TRUE(release[1].wait());
  });
  executor.post(first);
  executor.post(second);
  ASSERT_TRUE(entered[0].wait());
  ASSERT_TRUE(entered[1].wait());
  EXPECT_FALSE(executor.close(node, clock.now()));
  release[0].open();
  EXPECT_FALSE(executor.close(node, clock.now()));
  release[1].open();
  EXPECT_TRUE(executor.close(node, clock.now() + 20s));
}

TEST_F(GroupsTest, a_wait_that_would_never_end_is_named) {
  Executor single{"single", clock, {}};
  NodeGroups shared{single, "/shared", [](const auto&...) {}};
  NodeGroups neighbour{single, "/neighbour", [](const auto&...) {}};
  single.open(shared);
  single.open(neighbour);
  CallbackGroup group{shared}, other{shared};
  std::string same_group, other_group, own_transition, their_transition, two_threads, in_transition;
  Callable asks(group, [&] {
    same_group = single.why_not_wait_for(group);
    other_group = single.why_not_wait_for(other);
    their_transition = single.why_not_wait_for(neighbour);
  });
  single.post(asks);
  drain(group);
  Callable of_many(one, [&] {
    two_threads = executor.why_not_wait_for(two);
    own_transition = executor.why_not_wait_for(node);
  });
  executor.post(of_many);
  drain(one);
  Callable transition(
      group, [&] { in_transition = single.why_not_wait_for(other); }, Executable::Kind::Transition);
  single.post(transition);
  drain(group);

  const std::string way_out = "; do not wait in a callback, or wait in a thread of your own";
  EXPECT_EQ(same_group,
            "a callback of /shared would wait for itself: callbacks of one mutually exclusive group run one at "
            "a time" +
                way_out);
  EXPECT_EQ(other_group, "a callback of /shared would wait for itself: executor 'single' has one thread" + way_out);
  EXPECT_EQ(their_transition, other_group);
  EXPECT_EQ(own_transition,
            "a callback of /node would wait for itself: a transition waits for all callbacks of its node" + way_out);
  EXPECT_EQ(two_threads, "");
  EXPECT_EQ(in_transition,
            "a callback of /shared would wait for itself: a lifecycle transition runs alone in its node" + way_out);
  EXPECT_EQ(single.why_not_wait_for(group), "") << "this is no thread of its";
}

TEST(CallbackStats, hold_count_duration_and_the_cost_of_a_sample) {
  test::ManualClock clock;
  Executor executor{"stats", clock, threads(1)};
  NodeGroups node{executor, "/node", [](const auto&...) {}};
  executor.open(node);
  CallbackGroup group{node};
  CallbackStats stats;
  std::atomic<int> runs{0};
  std::atomic<unsigned> worked{0};
  Callable busy(group, [&] {
    clock.advance(++runs == 1000 ? 7ms : 1ms);
    for (int i = 0; i < 2000; ++i) worked = worked * 31 + i;
  });
  busy.keep_stats_in(stats);
  busy.again = [&] { return runs < 1000; };
  executor.post(busy);
  drain(group);
  while (runs < 1000) drain(group);
  drain(group);

  EXPECT_EQ(stats.duration.count(), 1000U);
  EXPECT_EQ(stats.duration.max(), 7ms);
  EXPECT_GE(stats.duration.quantile(0.5), 1ms);
  EXPECT_LE(stats.duration.quantile(0.5), 1.125ms) << "a bucket is at most 12.5 % wide";
  LoadReport load;
  executor.report_load(node, load);
  EXPECT_GE(load.callbacks, 1002U);
  EXPECT_GE(load.samples, load.callbacks / 192);
  EXPECT_LE(load.samples, load.callbacks / 65 + 1);
  EXPECT_GT(load.cpu, 0ns);
  std::vector<ThreadReport> all;
  std::size_t used = 0;
  executor.report_threads(all, used);
  ASSERT_EQ(used, 1U);
  EXPECT_STREQ(all[0].state, "serving");
  EXPECT_GT(all[0].cpu, 0ns);
}

TEST(TimerQueue, is_a_sorted_list_whatever_is_put_in_and_taken_out) {
  test::ManualClock clock;
  Executor executor{"timers", clock, threads(1)};
  NodeGroups node{executor, "/node", [](const auto&...) {}};
  CallbackGroup group{node};
  for (const unsigned seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(seed);
    std::mt19937 random{seed};
    std::vector<std::unique_ptr<Tick>> timers;
    timers.reserve(50);
    for (int i = 0; i < 50; ++i) timers.push_back(std::make_unique<Tick>(group, 1ns, [] {}));
    TimerQueue queue;
    std::vector<std::pair<MonotonicTime, TimerBase*>> model;  // in the order of adding
    for (int step = 0; step < 5000; ++step) {
      Tick* const timer = timers[random() % timers.size()].get();
      const auto found = std::ranges::find(model, static_cast<TimerBase*>(timer), &decltype(model)::value_type::second);
      if (random() % 3 == 0) {
        queue.remove(*timer);
        if (found != model.end()) model.erase(found);
      } else {
        const MonotonicTime due{Duration{random() % 40}};
        queue.put(*timer, due);
        if (found != model.end()) {
          found->first = due;
        } else {
          model.emplace_back(due, timer);
        }
      }
      ASSERT_EQ(queue.size(), model.size());
      const auto next = std::ranges::min_element(model, {}, &decltype(model)::value_type::first);
      ASSERT_EQ(queue.next_due(), next == model.end() ? kNever : next->first) << "step " << step;
      if (next == model.end()) continue;
      ASSERT_EQ(&queue.first(), next->second) << "of several, the one that was added first";
    }
    for (const auto& timer : timers) queue.remove(*timer);
  }
}

TEST(ExecutorThreads, carry_the_name_and_the_cpus_of_their_policy) {
  SystemClock clock;
  Executor executor{"a_name_longer_than_fifteen", clock, {.own = true, .priority = 0, .cpus = {0}, .threads = 2}};
  NodeGroups node{executor, "/node", [](const auto&...) {}};
  executor.open(node);
  CallbackGroup group{node, CallbackGroupType::Reentrant};
  Meeting meeting;
  Callable first(group, [&] { EXPECT_TRUE(meeting.meet()); }), second(group, [&] { EXPECT_TRUE(meeting.meet()); });
  executor.post(first);
  executor.post(second);
  drain(group);
  std::vector<ThreadReport> all;
  std::size_t used = 0;
  executor.report_threads(all, used);
  ASSERT_EQ(used, 2U);
  for (const auto& thread : all) {
    const std::string folder = "/proc/self/task/" + std::to_string(thread.thread_id);
    std::string name, line, cpus;
    std::getline(std::ifstream(folder + "/comm") >> std::ws, name);
    std::ifstream status(folder + "/status");
    while (std::getline(status, line)) {
      if (line.rfind("Cpus_allowed_list:", 0) == 0) cpus = line.substr(line.find_last_of(" \t") + 1);
    }
    EXPECT_EQ(name, "a_name_longer_t");
    EXPECT_EQ(cpus, "0");
  }
}

TEST(ExecutorThreads, get_their_priority_or_say_that_they_did_not) {
  SystemClock clock;
  ::testing::internal::CaptureStderr();
  int policy = -1;
  {
    Executor executor{"eager", clock, {.own = true, .priority = 7, .cpus = {1023}, .threads = 2}};
    NodeGroups node{executor, "/node", [](const auto&...) {}};
    executor.open(node);
    CallbackGroup group{node, CallbackGroupType::Reentrant};
    Meeting meeting;
    Callable first(group, [&] {
      policy = sched_getscheduler(0);
      EXPECT_TRUE(meeting.meet());
    });
    Callable second(group, [&] { EXPECT_TRUE(meeting.meet()); });
    executor.post(first);
    executor.post(second);
    drain(group);
  }
  const std::string said = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(policy == SCHED_FIFO, said.find("no SCHED_FIFO priority 7") == std::string::npos) << said;
  EXPECT_NE(said.find("cannot be bound to cpus 1023"), std::string::npos) << said;
  EXPECT_EQ(said.find("cannot be bound"), said.rfind("cannot be bound")) << "said once, not per thread";
}

}  // namespace
}  // namespace nacelle::runtime
