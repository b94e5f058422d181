// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/executor.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <future>
#include <stdexcept>

#include "support/manual_clock.hpp"

namespace nacelle::runtime {
namespace {

class Callable final : public Executable {
 public:
  Callable(CallbackGroup& group, std::function<void()> what) : Executable(group), what_(std::move(what)) {}
  ~Callable() override { group().executor().forget(*this); }
  void execute(MonotonicTime) override { what_(); }

 private:
  std::function<void()> what_;
};

struct ExecutorTest : ::testing::Test {
  SystemClock clock;  // real threads sleep in real time; no test here asserts a duration
  std::mutex mutex;
  std::vector<FaultReason> faults;
  Executor executor{"executor", clock, {}};
  CallbackGroup a = group("/a"), b = group("/b");

  CallbackGroup group(const std::string& name) {
    return {executor, name, [this](std::string code, std::string text) {
              const std::lock_guard lock(mutex);
              faults.push_back({std::move(code), std::move(text)});
            }};
  }
  // Everything posted before has run when this returns.
  void drain(CallbackGroup& g) {
    std::promise<void> done;
    Callable last(g, [&] { done.set_value(); });
    executor.post(last);
    done.get_future().wait();
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
  Callable good(b, [&] { ran = true; });
  executor.post(bad);
  executor.post(good);
  drain(b);
  EXPECT_TRUE(ran);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, "EXCEPTION");
  EXPECT_EQ(faults[0].text, "no such register");
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
  while (executor.handovers() == 0) executor.supervise({1us, 1h});
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
  executor.post(stuck);
  entered.get_future().wait();
  while (faults.empty()) executor.supervise({1us, 2us});
  for (int i = 0; i < 10; ++i) executor.supervise({1us, 2us});
  release.set_value();
  drain(a);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, "HUNG");
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

TEST_F(ExecutorTest, a_closed_group_starts_nothing_more) {
  bool ran = false;
  Callable late(a, [&] { ran = true; });
  EXPECT_TRUE(executor.close(a, clock.now() + 10s));
  executor.post(late);
  drain(b);
  EXPECT_FALSE(ran);
}

TEST_F(ExecutorTest, what_waits_in_a_group_that_is_closed_is_dropped_and_told) {
  struct Dropping final : Executable {
    explicit Dropping(CallbackGroup& g) : Executable(g) {}
    void execute(MonotonicTime) override { ++runs; }
    void on_dropped() noexcept override { ++drops; }
    int runs = 0, drops = 0;
  } in_backlog(a), in_queue(b);
  std::promise<void> entered, release;
  Callable slow(a, [&] {
    entered.set_value();
    release.get_future().wait();
  });
  executor.post(slow);
  entered.get_future().wait();
  executor.post(in_backlog);
  executor.post(in_queue);
  EXPECT_TRUE(executor.close(b, clock.now()));
  EXPECT_FALSE(executor.close(a, clock.now())) << "its callback still runs";
  EXPECT_EQ(in_queue.drops, 1);
  EXPECT_EQ(in_backlog.drops, 1);
  release.set_value();
  EXPECT_TRUE(executor.close(a, clock.now() + 10s));
  EXPECT_EQ(in_queue.runs + in_backlog.runs, 0);
}

TEST_F(ExecutorTest, a_held_group_runs_what_was_ready_when_it_is_opened) {
  bool ran = false;
  Callable early(a, [&] { ran = true; });
  executor.hold(a);
  executor.post(early);
  drain(b);
  EXPECT_FALSE(ran);
  executor.open(a);
  drain(a);
  EXPECT_TRUE(ran);
}

TEST_F(ExecutorTest, what_may_take_long_makes_way_before_it_begins) {
  struct Long final : Executable {
    explicit Long(CallbackGroup& g) : Executable(g) {}
    void execute(MonotonicTime) override {
      entered.set_value();
      release.get_future().wait();
    }
    bool may_take_long() const override { return true; }
    std::promise<void> entered, release;
  } transition(a);
  executor.post(transition);
  transition.entered.get_future().wait();
  drain(b);  // nobody supervises here
  transition.release.set_value();
  executor.forget(transition);
}

class Tick final : public TimerBase {
 public:
  Tick(CallbackGroup& g, Duration period, std::function<void()> what) : TimerBase(g, period), what_(std::move(what)) {}
  ~Tick() override {
    group().executor().cancel_timer(*this);
    group().executor().forget(*this);
  }
  void execute(MonotonicTime) override { what_(); }

 private:
  std::function<void()> what_;
};

TEST_F(ExecutorTest, a_timer_that_is_always_late_does_not_starve_the_others) {
  std::promise<void> ten_others;
  std::atomic<int> others{0}, ticks{0};
  Tick greedy(a, 1ns, [&] { ++ticks; });
  Tick modest(b, 1us, [&] {
    if (++others == 10) ten_others.set_value();
  });
  executor.add_timer(greedy);
  executor.add_timer(modest);
  ten_others.get_future().wait();
  EXPECT_GT(ticks.load(), 0);
}

}  // namespace
}  // namespace nacelle::runtime
