// SPDX-License-Identifier: Apache-2.0
// Executors without a thread: run_ready() runs everything, at the time that the clock is told.
#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "executor_fixture.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::runtime {
namespace {

struct ExecutorByCaller : ::testing::Test {
  test::ManualClock clock;
  std::vector<std::string> faults;
  Executor executor{"executor", clock, {}, Running::ByCaller};
  NodeGroups node_a{executor, "/a", [this](std::string code, const std::string&, const std::string&) {
                      faults.push_back(std::move(code));
                    }};
  NodeGroups node_b{executor, "/b", [](const auto&...) {}};
  CallbackGroup a{node_a}, b{node_b};
  std::string order;

  void SetUp() override {
    executor.open(node_a);
    executor.open(node_b);
  }
};

TEST_F(ExecutorByCaller, runs_nothing_until_it_is_told_to_and_then_all_on_this_thread_in_their_order) {
  const auto here = std::this_thread::get_id();
  Callable third(a, [&] { order += std::this_thread::get_id() == here ? '3' : '?'; });
  Callable first(b, [&] {
    order += '1';
    executor.post(third);
  });
  Callable second(a, [&] { order += '2'; });
  executor.post(first);
  executor.post(second);
  EXPECT_EQ(order, "");
  EXPECT_FALSE(executor.is_idle());
  executor.run_ready();
  EXPECT_EQ(order, "123");
  EXPECT_TRUE(executor.is_idle());
}

TEST_F(ExecutorByCaller, ticks_when_the_clock_says_so) {
  EXPECT_EQ(executor.next_timer(), kNever);
  const MonotonicTime begin = clock.now();
  Tick slow(a, 20ms, [&] { order += 's'; }), fast(b, 10ms, [&] { order += 'f'; });
  executor.add_timer(slow);
  executor.add_timer(fast);
  executor.run_ready();
  EXPECT_EQ(order, "");
  EXPECT_EQ(executor.next_timer(), begin + 10ms);
  clock.advance(10ms);
  executor.run_ready();
  EXPECT_EQ(order, "f");
  clock.advance(10ms);
  executor.run_ready();
  EXPECT_EQ(order, "fsf") << "at one time, in the order of their beginning";
  EXPECT_EQ(executor.next_timer(), begin + 30ms);
}

TEST_F(ExecutorByCaller, a_call_from_within_a_callback_does_nothing) {
  Callable second(b, [&] { order += '2'; });
  Callable first(a, [&] {
    executor.post(second);
    executor.run_ready();
    order += '1';
  });
  executor.post(first);
  executor.run_ready();
  EXPECT_EQ(order, "12");
}

TEST_F(ExecutorByCaller, a_transition_hands_nothing_over_and_a_callback_that_throws_is_a_fault) {
  Callable other(b, [&] { order += 'o'; });
  Callable transition(
      a,
      [&] {
        executor.post(other);
        order += 't';
        throw std::runtime_error("no such register");
      },
      Executable::Kind::Transition);
  executor.post(transition);
  executor.run_ready();
  EXPECT_EQ(order, "to");
  EXPECT_EQ(faults, std::vector<std::string>{"EXCEPTION"});
  EXPECT_EQ(executor.thread_count(), 1U) << "no spare thread was made";
}

TEST_F(ExecutorByCaller, what_destroys_itself_or_is_still_ready_at_the_end_does_no_harm) {
  std::unique_ptr<Callable> gone;
  gone = std::make_unique<Callable>(a, [&] { gone.reset(); });
  executor.post(*gone);
  executor.run_ready();
  EXPECT_EQ(gone, nullptr);
  Callable left(a, [&] { order += 'l'; });
  executor.post(left);
  EXPECT_TRUE(executor.close(node_a, clock.now()));
  executor.run_ready();
  EXPECT_EQ(order, "");
  EXPECT_TRUE(left.discarded);
}

}  // namespace
}  // namespace nacelle::runtime
