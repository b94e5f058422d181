// SPDX-License-Identifier: Apache-2.0
// use_sim_time: a node's ROS time follows /clock, its monotonic time does not.
#include <gtest/gtest.h>

#include <atomic>
#include <bit>
#include <condition_variable>
#include <mutex>
#include <rosgraph_msgs/msg/clock.hpp>
#include <thread>

#include "benchmark/support/recipe.hpp"
#include "nacelle/runtime/container.hpp"
#include "support/places.hpp"

namespace nacelle::runtime {
namespace {

/// Shows the node to the test.
class Window final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& made) override {
    node = &made;
    at_build = made.now();
    return nullptr;
  }
  LifecycleNode* node = nullptr;
  WallTime at_build{};
};

class SimTime : public ::testing::Test {
 protected:
  static ContainerOptions with_plugins() {
    ContainerOptions options;
    options.component_path = {test::component_folder()};
    return options;
  }
  std::uint64_t load(bench::Recipe& window, const std::string& name, std::optional<bool> use_sim_time) {
    LoadRequest request;
    request.plugin = "nacelle::bench::Part";
    request.name = name;
    request.parameters = {{"recipe", static_cast<std::int64_t>(std::bit_cast<std::intptr_t>(&window))}};
    if (use_sim_time) request.parameters["use_sim_time"] = *use_sim_time;
    const auto loaded = container_.load(request);
    EXPECT_TRUE(loaded) << loaded.error().text();
    return loaded ? loaded.value().id : 0;
  }
  void say(std::int32_t sec, std::uint32_t nanosec) {
    using rosgraph_msgs::msg::Clock;
    if (!writer_) writer_ = container_.transport().create_writer({"/clock", &Clock::message_type(), QoS(1), "/world"});
    Block* const block = writer_->borrow();
    auto& time = static_cast<Clock*>(block->message)->clock;
    time.sec = sec;
    time.nanosec = nanosec;
    ASSERT_EQ(writer_->publish(*block), PublishResult::Published);
  }

  SystemClock clock_;
  Window first_, second_;  // outlive their components
  Container container_{with_plugins(), clock_};
  std::unique_ptr<Writer> writer_;
};

TEST_F(SimTime, is_zero_before_the_first_message_then_the_last_value_of_clock) {
  load(first_, "first", true);
  EXPECT_EQ(first_.at_build, WallTime{});
  say(1000, 5);
  EXPECT_EQ(first_.node->now(), (WallTime{1000s + 5ns}));
  say(400, 0);
  EXPECT_EQ(first_.node->now(), WallTime{400s}) << "a log that is played again goes back";
}

TEST_F(SimTime, is_for_those_nodes_that_ask_for_it) {
  load(first_, "first", true);
  load(second_, "second", false);
  say(1000, 0);
  EXPECT_EQ(first_.node->now(), WallTime{1000s});
  EXPECT_GT(second_.node->now(), WallTime{1'500'000'000s});
}

TEST_F(SimTime, leaves_the_monotonic_time_alone) {
  load(first_, "first", true);
  const MonotonicTime before = clock_.now();
  say(5, 0);
  const MonotonicTime seen = first_.node->steady_clock().now();
  EXPECT_GE(seen, before);
  EXPECT_LE(seen, clock_.now());
}

TEST_F(SimTime, a_node_that_comes_later_has_the_time_of_those_that_are_there) {
  load(first_, "first", true);
  say(77, 0);
  load(second_, "second", true);
  EXPECT_EQ(second_.at_build, WallTime{77s});
}

/// A node that counts the ticks of two timers, one of each clock.
class Beats final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& made) override {
    auto both = std::make_shared<std::pair<Timer::SharedPtr, Timer::SharedPtr>>(
        made.create_timer(100ms, [this] { count(clock_ticks_); }),
        made.create_wall_timer(1ms, [this] { count(wall_ticks_); }));
    on_clock = both->first.get();
    return both;
  }
  /// Waits until the timer of the clock has ticked so often in all.
  [[nodiscard]] bool wait_for(int ticks) {
    std::unique_lock lock(mutex_);
    return ticked_.wait_for(lock, 10s, [&] { return clock_ticks_ >= ticks; });
  }
  /// Waits until the wall timer has gone on so far that a tick that was due would have come.
  [[nodiscard]] int after_a_while() {
    std::unique_lock lock(mutex_);
    const int begin = wall_ticks_;
    EXPECT_TRUE(ticked_.wait_for(lock, 10s, [&] { return wall_ticks_ >= begin + 10; }));
    return clock_ticks_;
  }
  Timer* on_clock = nullptr;  // the node's

 private:
  void count(int& ticks) {
    const std::lock_guard lock(mutex_);
    ++ticks;
    ticked_.notify_all();
  }
  std::mutex mutex_;
  std::condition_variable ticked_;
  int clock_ticks_ = 0, wall_ticks_ = 0;
};

class SimTimer : public SimTime {
 protected:
  void start(bool use_sim_time = true) {
    id_ = load(beats_, "beats", use_sim_time);
    for (const Transition step : {Transition::Configure, Transition::Activate}) {
      const auto outcome = container_.trigger(id_, step);
      ASSERT_TRUE(outcome.success) << outcome.reason;
    }
  }
  void say_ms(std::int64_t ms) {
    say(static_cast<std::int32_t>(ms / 1000), static_cast<std::uint32_t>(ms % 1000) * 1'000'000U);
  }
  // Callbacks of the recipe end with the component.
  void TearDown() override {
    if (id_ != 0) static_cast<void>(container_.unload(id_));
  }
  Beats beats_;
  std::uint64_t id_ = 0;
};

TEST_F(SimTimer, follows_the_clock_and_not_the_time_that_passes) {
  start();
  EXPECT_EQ(beats_.after_a_while(), 0) << "no time has come yet";
  say_ms(50'000);  // the first time is where its first period begins
  say_ms(50'099);
  EXPECT_EQ(beats_.after_a_while(), 0);
  say_ms(50'100);
  EXPECT_TRUE(beats_.wait_for(1));
  EXPECT_EQ(beats_.after_a_while(), 1) << "the clock stands";
  for (int tick = 2; tick <= 20; ++tick) {
    say_ms(50'000 + tick * 100);
    ASSERT_TRUE(beats_.wait_for(tick));
  }
  EXPECT_EQ(beats_.after_a_while(), 20);
}

TEST_F(SimTimer, a_jump_ahead_is_one_tick_and_the_rhythm_stays) {
  start();
  say_ms(1'000);
  say_ms(1'100);
  ASSERT_TRUE(beats_.wait_for(1));
  say_ms(3'650);
  ASSERT_TRUE(beats_.wait_for(2));
  say_ms(3'699);
  EXPECT_EQ(beats_.after_a_while(), 2);
  say_ms(3'700);
  EXPECT_TRUE(beats_.wait_for(3));
}

TEST_F(SimTimer, after_a_jump_back_it_ticks_a_full_period_later) {
  start();
  say_ms(9'000);
  say_ms(9'100);
  ASSERT_TRUE(beats_.wait_for(1));
  say_ms(2'030);
  say_ms(2'129);
  EXPECT_EQ(beats_.after_a_while(), 1);
  say_ms(2'130);
  EXPECT_TRUE(beats_.wait_for(2));
}

TEST_F(SimTimer, a_small_step_back_changes_nothing) {
  start();
  say_ms(9'000);
  say_ms(9'080);
  say_ms(9'060);
  say_ms(9'100);
  EXPECT_TRUE(beats_.wait_for(1));
}

TEST_F(SimTimer, cancel_reset_and_the_lifecycle_gate_hold_as_for_a_wall_timer) {
  start();
  say_ms(1'000);
  beats_.on_clock->cancel();
  EXPECT_TRUE(beats_.on_clock->is_canceled());
  say_ms(1'500);
  EXPECT_EQ(beats_.after_a_while(), 0);
  beats_.on_clock->reset();
  EXPECT_FALSE(beats_.on_clock->is_canceled());
  say_ms(1'599);
  EXPECT_EQ(beats_.after_a_while(), 0) << "a full period from the reset";
  say_ms(1'600);
  ASSERT_TRUE(beats_.wait_for(1));
  ASSERT_TRUE(container_.trigger(id_, Transition::Deactivate).success);
  say_ms(2'000);
  ASSERT_TRUE(container_.trigger(id_, Transition::Activate).success);
  EXPECT_EQ(beats_.after_a_while(), 1) << "what came while it was not active is gone";
  say_ms(2'100);
  EXPECT_TRUE(beats_.wait_for(2));
}

TEST_F(SimTimer, is_a_wall_timer_in_a_node_without_sim_time) {
  start(false);
  EXPECT_TRUE(beats_.wait_for(2));
}

TEST_F(SimTimer, may_go_while_the_clock_runs) {
  start();
  std::atomic<bool> over{false};
  std::thread teller([&] {
    for (std::int64_t ms = 1; !over; ++ms) say_ms(1'000 + ms * 100);
  });
  ASSERT_TRUE(beats_.wait_for(10));
  EXPECT_TRUE(container_.unload(std::exchange(id_, 0)));
  over = true;
  teller.join();
}

}  // namespace
}  // namespace nacelle::runtime
