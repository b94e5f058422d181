// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/executor.hpp"

#include <gtest/gtest.h>

#include <future>
#include <mutex>
#include <stdexcept>

#include "executor_fixture.hpp"
#include "nacelle/host/lifecycle_state.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::runtime {
namespace {

struct ExecutorTest : ::testing::Test {
  SystemClock clock;  // real threads sleep in real time; no test here asserts a duration
  std::mutex mutex;
  std::vector<FaultReason> faults;
  std::vector<std::string> where;
  NodeGroups::OnFault on_fault = [this](std::string code, std::string text, std::string callback) {
    const std::lock_guard lock(mutex);
    where.push_back(std::move(callback));
    faults.push_back({std::move(code), std::move(text)});
  };
  Executor executor{"executor", clock, {}};
  NodeGroups node_a{executor, "/a", on_fault}, node_b{executor, "/b", on_fault};
  CallbackGroup a{node_a}, b{node_b};

  void SetUp() override {
    executor.open(node_a);
    executor.open(node_b);
  }
};

TEST_F(ExecutorTest, runs_what_is_ready_in_the_order_in_which_it_became_ready) {
  std::string order;
  std::promise<void> gate;
  Callable hold(a, [&] { gate.get_future().wait(); });
  Callable one(a, [&] { order += '1'; }), two(b, [&] { order += '2'; }), three(a, [&] { order += '3'; });
  executor.post(hold);
  executor.post(two);
  executor.post(one);
  executor.post(three);
  executor.post(two);  // once is enough
  gate.set_value();
  drain(a);
  EXPECT_EQ(order, "213");
}

TEST_F(ExecutorTest, a_callback_that_throws_becomes_a_fault_and_the_others_go_on) {
  bool ran = false;
  Callable bad(a, [] { throw std::runtime_error("no such register"); });
  bad.describe_as("subscription", "/scan");
  Callable good(b, [&] { ran = true; });
  executor.post(bad);
  executor.post(good);
  drain(b);
  EXPECT_TRUE(ran);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, "EXCEPTION");
  EXPECT_EQ(faults[0].text, "no such register");
  EXPECT_EQ(where[0], "subscription /scan");
}

TEST_F(ExecutorTest, a_callback_that_overstays_loses_the_executor_but_keeps_its_group) {
  std::promise<void> entered, release, other_ran;
  std::atomic<bool> mine_ran{false};
  Callable slow(a, [&] {
    entered.set_value();
    release.get_future().wait();
  });
  Callable mine(a, [&] { mine_ran = true; });
  Callable other(b, [&] { other_ran.set_value(); });
  executor.post(slow);
  entered.get_future().wait();
  executor.post(mine);
  executor.post(other);
  while (executor.handovers() == 0) static_cast<void>(executor.supervise({1us, 1h}));
  other_ran.get_future().wait();  // on the spare thread, while `slow` still runs
  EXPECT_FALSE(mine_ran);         // its own group waits for it
  release.set_value();
  drain(a);
  EXPECT_TRUE(mine_ran);
  EXPECT_TRUE(faults.empty());
}

TEST_F(ExecutorTest, a_callback_that_hangs_is_a_fault_once) {
  std::promise<void> entered, release;
  Callable stuck(a, [&] {
    entered.set_value();
    release.get_future().wait();
  });
  stuck.describe_as("timer", "10 ms");
  executor.post(stuck);
  entered.get_future().wait();
  while (faults.empty()) executor.supervise({1us, 2us});
  for (int i = 0; i < 10; ++i) executor.supervise({1us, 2us});
  release.set_value();
  drain(a);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, "HUNG");
  EXPECT_EQ(where[0], "timer 10 ms");
}

TEST_F(ExecutorTest, has_stalled_if_something_waits_and_nothing_starts_between_two_looks) {
  std::promise<void> entered, release;
  Callable stuck(a, [&] {
    entered.set_value();
    release.get_future().wait();
  });
  Callable waits(b, [] {});
  EXPECT_FALSE(executor.has_stalled());
  EXPECT_FALSE(executor.has_stalled()) << "nothing waits";
  executor.post(stuck);
  entered.get_future().wait();
  executor.post(waits);

  EXPECT_FALSE(executor.has_stalled()) << "the first look at it";
  EXPECT_TRUE(executor.has_stalled()) << "no thread takes the queue from the late one, since there is no supervisor";

  while (executor.handovers() == 0) static_cast<void>(executor.supervise({1us, 1h}));
  drain(b);
  EXPECT_FALSE(executor.has_stalled()) << "the late one still runs, and the others have run";
  EXPECT_FALSE(executor.has_stalled());
  release.set_value();
  drain(a);
}

TEST_F(ExecutorTest, has_not_stalled_if_something_starts_between_two_looks) {
  Door first_entered, first_release, second_entered, second_release;
  Callable first(a, [&] {
    first_entered.open();
    EXPECT_TRUE(first_release.wait());
  });
  Callable second(a, [&] {
    second_entered.open();
    EXPECT_TRUE(second_release.wait());
  });
  Callable third(a, [] {});
  for (Callable* const each : {&first, &second, &third}) executor.post(*each);
  EXPECT_TRUE(first_entered.wait());
  EXPECT_FALSE(executor.has_stalled());
  first_release.open();
  EXPECT_TRUE(second_entered.wait());
  EXPECT_FALSE(executor.has_stalled()) << "something waits at both looks, and one has started meanwhile";
  second_release.open();
  drain(a);
}

TEST_F(ExecutorTest, a_component_that_hangs_on_its_own_threads_is_no_stall) {
  Executor own{"own", clock, {.own = true}};
  NodeGroups node{own, "/own", on_fault};
  CallbackGroup group{node};
  own.open(node);
  Door entered, release;
  Callable stuck(group, [&] {
    entered.open();
    EXPECT_TRUE(release.wait());
  });
  Callable waits(group, [] {});
  own.post(stuck);
  EXPECT_TRUE(entered.wait());
  own.post(waits);
  for (int look = 0; look < 3; ++look) EXPECT_FALSE(own.has_stalled());
  release.open();
  drain(group);
}

TEST_F(ExecutorTest, late_threads_are_used_again_as_spares) {
  for (int round = 0; round < 5; ++round) {
    std::promise<void> entered, release;
    Callable slow(a, [&] {
      entered.set_value();
      release.get_future().wait();
    });
    executor.post(slow);
    entered.get_future().wait();
    const auto before = executor.handovers();
    while (executor.handovers() == before) executor.supervise({1us, 1h});
    release.set_value();
    drain(a);
  }
  EXPECT_EQ(executor.handovers(), 5U);
  EXPECT_LE(executor.thread_count(), 3U);
}

TEST_F(ExecutorTest, forget_waits_for_a_run_that_goes_on) {
  std::promise<void> entered, release;
  std::atomic<bool> ended{false};
  auto slow = std::make_unique<Callable>(a, [&] {
    entered.set_value();
    release.get_future().wait();
    ended = true;
  });
  executor.post(*slow);
  entered.get_future().wait();
  auto destroyed = std::async(std::launch::async, [&] {
    slow.reset();
    return ended.load();
  });
  release.set_value();
  EXPECT_TRUE(destroyed.get());
}

TEST_F(ExecutorTest, a_closed_node_starts_nothing_more_and_notifies_waiting_tasks) {
  Door entered, release;
  bool ran = false;
  Callable hold(b, [&] {
    entered.open();
    EXPECT_TRUE(release.wait());
  });
  Callable waiting(a, [&] { ran = true; }), late(a, [&] { ran = true; });
  executor.post(hold);
  ASSERT_TRUE(entered.wait());
  EXPECT_TRUE(executor.post(waiting));
  EXPECT_TRUE(executor.close(node_a, clock.now() + 10s));
  EXPECT_TRUE(waiting.discarded);
  EXPECT_FALSE(executor.post(late));
  release.open();
  drain(b);
  EXPECT_FALSE(ran);
}

TEST_F(ExecutorTest, nothing_of_a_node_runs_before_it_is_opened) {
  NodeGroups made{executor, "/made", on_fault};
  CallbackGroup group{made};
  std::atomic<bool> ran{false};
  Callable early(group, [&] { ran = true; });
  executor.post(early);
  drain(a);
  EXPECT_FALSE(ran) << "while the constructor of its node may still run";
  executor.open(made);
  drain(group);
  EXPECT_TRUE(ran);
}

TEST_F(ExecutorTest, a_transition_takes_no_time_from_the_other_nodes) {
  Door entered, release;
  Callable transition(
      a,
      [&] {
        entered.open();
        EXPECT_TRUE(release.wait());
      },
      Executable::Kind::Transition);
  executor.post(transition);
  ASSERT_TRUE(entered.wait());
  drain(b);  // there is no supervisor here: the queue was handed over before the transition began
  EXPECT_EQ(executor.handovers(), 0U);
  release.open();
  drain(a);
  EXPECT_EQ(executor.thread_count(), 2U);
}

TEST_F(ExecutorTest, a_node_exists_until_the_report_of_its_hang_has_returned) {
  Door entered, release, telling, told;
  auto node = std::make_unique<NodeGroups>(executor, "/slow", [&](const auto&...) {
    telling.open();
    EXPECT_TRUE(told.wait());
  });
  CallbackGroup group{*node};
  executor.open(*node);
  Callable stuck(group, [&] {
    entered.open();
    EXPECT_TRUE(release.wait());
  });
  executor.post(stuck);
  ASSERT_TRUE(entered.wait());
  auto watching = std::async(std::launch::async, [&] {
    while (executor.handovers() == 0) static_cast<void>(executor.supervise({1us, 2us}));
  });
  ASSERT_TRUE(telling.wait());
  release.open();
  drain(a);  // the callback has returned, and its fault is still being reported
  EXPECT_FALSE(executor.close(*node, clock.now()));
  told.open();
  EXPECT_TRUE(executor.close(*node, clock.now() + 20s));
  watching.wait();
}

TEST_F(ExecutorTest, a_timer_that_is_always_late_does_not_starve_the_others) {
  Door hundred;
  std::atomic<int> others{0}, ticks{0};
  int in_a_row = 0, most = 0;
  Tick greedy(a, 1ns, [&] {
    ++ticks;
    if (others < 100) most = std::max(most, ++in_a_row);
  });
  Callable modest(b, [&] {
    in_a_row = 0;
    if (++others == 100) hundred.open();
  });
  modest.again = [&] { return others < 100; };
  Door begin;
  Callable hold(a, [&] { EXPECT_TRUE(begin.wait()); });
  executor.post(hold);
  executor.add_timer(greedy);
  executor.post(modest);
  begin.open();
  ASSERT_TRUE(hundred.wait());
  executor.cancel_timer(greedy);
  drain(a);
  EXPECT_GE(ticks, 90) << "and it is not starved either";
  EXPECT_LE(most, 1) << "between two runs of one callback, each other one that is ready has run";
}

TEST_F(ExecutorTest, streams_that_are_always_full_take_turns) {
  constexpr int kStreams = 5, kRounds = 1000;
  std::vector<int> runs(kStreams);
  Door done;
  std::vector<std::unique_ptr<Callable>> streams;
  int worst = 0;
  for (int i = 0; i < kStreams; ++i) {
    streams.push_back(std::make_unique<Callable>(i % 2 == 0 ? a : b, [&, i] {
      ++runs[i];
      const auto [fewest, most] = std::minmax_element(runs.begin(), runs.end());
      worst = std::max(worst, *most - *fewest);
      if (*fewest == kRounds) done.open();
    }));
    streams.back()->again = [&, i] { return runs[i] < kRounds; };
  }
  Door all_posted;
  Callable hold(a, [&] { EXPECT_TRUE(all_posted.wait()); });
  executor.post(hold);
  for (const auto& stream : streams) executor.post(*stream);
  all_posted.open();
  ASSERT_TRUE(done.wait());
  EXPECT_LE(worst, 1);
}

struct TimerBeats : ::testing::Test {
  test::ManualClock clock;
  Executor executor{"executor", clock, {}};
  NodeGroups node{executor, "/a", [](const auto&...) {}};
  CallbackGroup group{node};
};

TEST_F(TimerBeats, timers_made_in_a_constructor_share_the_beats_of_their_period_and_are_never_early) {
  const MonotonicTime made = clock.now();
  clock.advance(3ms);
  Tick first(group, 10ms, [] {}), second(group, 10ms, [] {}), third(group, 100ms, [] {}), slow(group, 2s, [] {});

  executor.add_timer(first);
  clock.advance(4ms);
  for (Tick* timer : {&second, &third, &slow}) executor.add_timer(*timer);

  EXPECT_EQ(first.due(), made + 20ms);
  EXPECT_EQ(second.due(), made + 20ms);
  EXPECT_EQ(third.due(), made + 200ms);
  EXPECT_EQ(slow.due(), made + 2007ms) << "slow timers keep their own time";
}

TEST_F(TimerBeats, a_reset_and_a_timer_made_while_the_node_runs_get_a_full_period_from_now) {
  const MonotonicTime made = clock.now();
  Tick watchdog(group, 100ms, [] {}), late(group, 100ms, [] {});
  clock.advance(3ms);
  executor.add_timer(watchdog);

  executor.add_timer(watchdog);  // before the node is open: a reset all the same
  EXPECT_EQ(watchdog.due(), made + 103ms);

  executor.open(node);
  clock.advance(4ms);
  executor.add_timer(late);
  EXPECT_EQ(late.due(), made + 107ms);
}

}  // namespace
}  // namespace nacelle::runtime
