// SPDX-License-Identifier: Apache-2.0
// use_sim_time: a node's ROS time follows /clock, its monotonic time does not.
#include <gtest/gtest.h>

#include <bit>
#include <rosgraph_msgs/msg/clock.hpp>

#include "benchmark/support/recipe.hpp"
#include "nacelle/runtime/container.hpp"

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
    options.component_path = {NACELLE_TEST_PLUGINS};
    return options;
  }
  void load(Window& window, const std::string& name, std::optional<bool> use_sim_time) {
    LoadRequest request;
    request.plugin = "nacelle::bench::Part";
    request.name = name;
    request.parameters = {
        {"recipe", static_cast<std::int64_t>(std::bit_cast<std::intptr_t>(static_cast<bench::Recipe*>(&window)))}};
    if (use_sim_time) request.parameters["use_sim_time"] = *use_sim_time;
    const auto loaded = container_.load(request);
    ASSERT_TRUE(loaded) << loaded.error().text();
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

TEST_F(SimTime, is_zero_before_the_first_message_then_what_clock_said_last) {
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
  const MonotonicTime seen = first_.node->get_clock().now();
  EXPECT_GE(seen, before);
  EXPECT_LE(seen, clock_.now());
}

TEST_F(SimTime, a_node_that_comes_later_has_the_time_of_those_that_are_there) {
  load(first_, "first", true);
  say(77, 0);
  load(second_, "second", true);
  EXPECT_EQ(second_.at_build, WallTime{77s});
}

}  // namespace
}  // namespace nacelle::runtime
