// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/supervisor.hpp"

#include <gtest/gtest.h>

#include <future>
#include <utility>

#include "executor_fixture.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::runtime {
namespace {

struct SupervisorTest : ::testing::Test {
  SystemClock clock;
  std::promise<std::string> fault;
  NodeGroups::OnFault on_fault = [this](std::string code, std::string, std::string) {
    fault.set_value(std::move(code));
  };
  Executor shared{"shared", clock, {}}, own{"own", clock, {.own = true}};
  NodeGroups node_a{shared, "/a", on_fault}, node_b{shared, "/b", on_fault}, apart{own, "/apart", on_fault};
  CallbackGroup a{node_a}, b{node_b}, c{apart};

  void SetUp() override {
    shared.open(node_a);
    shared.open(node_b);
    own.open(apart);
  }
};

TEST_F(SupervisorTest, a_late_callback_loses_the_shared_executor_though_the_supervisor_slept) {
  Supervisor supervisor{{5ms, 1h}};
  supervisor.add(shared);
  for (int round = 0; round < 3; ++round) {
    Door release, other_ran;
    Callable slow(a, [&] { EXPECT_TRUE(release.wait()); });
    Callable other(b, [&] { other_ran.open(); });
    shared.post(slow);
    shared.post(other);
    EXPECT_TRUE(other_ran.wait());
    release.open();
    drain(a);
  }
  EXPECT_EQ(shared.handovers(), 3U);
}

TEST_F(SupervisorTest, a_callback_behind_many_short_ones_is_late_as_well) {
  Supervisor supervisor{{5ms, 1h}};
  supervisor.add(shared);
  Door release, other_ran;
  Callable slow(a, [&] { EXPECT_TRUE(release.wait()); });
  Callable other(b, [&] { other_ran.open(); });
  std::atomic<int> ticks{0}, expected{50};
  // From a timer's wake-ups, each of which may put the check off.
  Tick tick(b, 1ms, [&] {
    if (++ticks == expected) shared.post(slow);
    if (ticks == expected) shared.post(other);
  });
  shared.add_timer(tick);
  EXPECT_TRUE(other_ran.wait());
  release.open();
  shared.cancel_timer(tick);
  drain(a);
}

TEST_F(SupervisorTest, a_hang_on_an_executor_of_one_component_is_found) {
  Supervisor supervisor{{1ms, 20ms}};
  supervisor.add(own);
  Door release;
  Callable stuck(c, [&] { EXPECT_TRUE(release.wait()); });
  own.post(stuck);
  EXPECT_EQ(fault.get_future().get(), "HUNG");
  release.open();
  drain(c);
}

TEST_F(SupervisorTest, callbacks_that_return_in_time_wake_it_hardly_ever) {
  constexpr Duration kLimit = 100ms;
  Supervisor supervisor{{kLimit, 1h}};
  supervisor.add(shared);
  std::promise<void> enough;
  std::uint64_t ticks = 0, pauses = 0;
  MonotonicTime last = clock.now();
  Tick tick(a, 2ms, [&] {
    const MonotonicTime now = clock.now();
    if (now - std::exchange(last, now) > kLimit / 2) ++pauses;  // of this machine: the check was not put off in time
    if (++ticks == 1000) enough.set_value();
  });
  shared.add_timer(tick);
  enough.get_future().wait();
  shared.cancel_timer(tick);
  drain(a);
  EXPECT_LE(supervisor.checks(), 1 + 2 * pauses) << "in 2 s, with a limit of 100 ms";
}

}  // namespace
}  // namespace nacelle::runtime
