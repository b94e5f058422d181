// SPDX-License-Identifier: Apache-2.0
// The log on /rosout: the node of a line, its content, and that logging never waits for readers.
#include "runtime/src/rosout.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <rcl_interfaces/msg/log.hpp>
#include <stdexcept>

#include "benchmark/support/recipe.hpp"
#include "container_fixture.hpp"
#include "nacelle/qos/presets.hpp"
#include "nacelle/runtime/broker.hpp"
#include "nacelle/runtime/executor.hpp"
#include "support/allocation_guard.hpp"

namespace nacelle::runtime {
namespace {

using rcl_interfaces::msg::Log;
using ::testing::EndsWith;
using ::testing::HasSubstr;

/// Reads /rosout.
class Lines : public TestSubscription<Log> {
 public:
  explicit Lines(Transport& transport, const QoS& qos = RosoutQoS{}) : TestSubscription(transport, "/rosout", qos) {}
  /// Returns the first line with this text.
  Log with(const std::string& text) {
    Log log;
    while (log.msg != text) log = next();
    return log;
  }
};

struct RosoutTest : ContainerTest {
  RosoutTest() : ContainerTest(ContainerOptions{.node_interfaces = NodeInterfaces::Isolated}) {}
  std::string node_of(std::uint64_t writer) const {
    for (const auto& end : container.endpoints()) {
      if (end.id == writer) return end.node;
    }
    return "(unknown writer)";
  }
};

TEST_F(RosoutTest, a_line_is_published_by_the_node_that_has_written_it) {
  load("Talker");
  Lines lines{container.transport()};
  const unsigned here = __LINE__ + 1;
  Logger{"talker"}.warn("the word is {}", "moo");
  const Log log = lines.with("the word is moo");
  EXPECT_EQ(node_of(lines.writer()), "/talker");
  EXPECT_EQ(log.level, Log::WARN);
  EXPECT_EQ(log.name, "talker");
  EXPECT_THAT(log.file, EndsWith("rosout_test.cpp"));
  EXPECT_EQ(log.function, "TestBody");
  EXPECT_EQ(log.line, here);
  EXPECT_GT(log.stamp.sec, 0);
  Logger{"talker.driver"}.info("a part of it");
  EXPECT_EQ(lines.with("a part of it").name, "talker.driver");
  EXPECT_EQ(node_of(lines.writer()), "/talker");
}

/// Logs a line in its constructor, and fails on request.
class Saying final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    node.get_logger().info("being made");
    if (fails) throw std::runtime_error("no device");
    return nullptr;
  }
  bool fails = false;
};

TEST_F(RosoutTest, a_line_of_a_constructor_is_the_nodes_and_one_that_fails_leaves_nothing) {
  Lines lines{container.transport()};
  Saying recipe;
  LoadRequest request;
  request.plugin = "nacelle::bench::Part";
  request.name = "base";
  request.parameters = {{"recipe", static_cast<std::int64_t>(std::bit_cast<std::intptr_t>(&recipe))}};
  const auto loaded = container.load(request);
  ASSERT_TRUE(loaded);
  EXPECT_EQ(lines.with("being made").name, "base");
  EXPECT_EQ(node_of(lines.writer()), "/base");
  recipe.fails = true;
  request.name = "other";
  EXPECT_FALSE(container.load(request));
  EXPECT_EQ(lines.with("being made").name, "other");
  for (const auto& end : container.endpoints()) EXPECT_NE(end.node, "/other") << end.topic;
}

TEST_F(RosoutTest, what_is_no_nodes_is_the_containers) {
  Lines lines{container.transport()};
  Logger{"network"}.error("no interface");
  EXPECT_EQ(lines.with("no interface").name, "network");
  EXPECT_EQ(node_of(lines.writer()), "/test");
}

TEST_F(RosoutTest, a_component_named_as_its_container_shares_its_writer) {
  Lines lines{container.transport()};
  const auto twin = load("Talker", {}, "test");
  Logger{"test"}.info("both");
  EXPECT_EQ(lines.with("both").name, "test");
  ASSERT_TRUE(container.unload(twin.id));
  Logger{"network"}.info("still there");
  EXPECT_EQ(lines.with("still there").name, "network");
}

TEST_F(RosoutTest, what_is_not_written_is_not_published) {
  Lines lines{container.transport()};
  Logger{"network"}.debug("not enabled");
  Logger{"network"}.info("enabled");
  EXPECT_EQ(lines.next().msg, "enabled");
}

TEST_F(RosoutTest, a_late_reader_gets_earlier_lines_but_not_those_of_an_unloaded_node) {
  const auto talker = load("Talker");
  Logger{"talker"}.info("before");
  {
    Lines first{container.transport()};
    first.with("before");  // it has been published
    Lines late{container.transport()};
    EXPECT_EQ(late.with("before").msg, "before");
  }
  ASSERT_TRUE(container.unload(talker.id));
  Logger{"talker"}.info("after its end");
  Lines lines{container.transport()};
  for (Log log = lines.next(); log.msg != "after its end"; log = lines.next()) ASSERT_NE(log.msg, "before");
  EXPECT_EQ(node_of(lines.writer()), "/test");
}

/// A Rosout whose thread is blocked until it is released.
struct StandingRosout : ::testing::Test {
  SystemClock clock;
  Broker broker{clock};
  Executor executor{"services", clock, {.own = true}};
  NodeGroups node{executor, "/test", [](const std::string&, const std::string&, const std::string&) {}};
  CallbackGroup group{node};
  Rosout rosout{group, broker, clock, "/test"};
};

TEST_F(StandingRosout, lines_that_find_no_room_are_dropped_counted_and_reported) {
  Lines lines{broker, QoS(100'000)};
  const Logger log{"noisy"};
  constexpr int kLines = 2000;
  const std::string long_text(100, 'x');
  for (int i = 0; i < kLines; ++i) log.info("{} {}", i, long_text);
  executor.open(node);
  int came = 0;
  Log last;
  for (last = lines.next(); last.name == "noisy"; last = lines.next())
    EXPECT_THAT(last.msg, HasSubstr(std::to_string(came++)));
  EXPECT_GT(came, 100);
  EXPECT_LT(came, kLines);
  EXPECT_EQ(rosout.dropped(), static_cast<std::uint64_t>(kLines - came));
  EXPECT_EQ(last.name, "test");
  EXPECT_EQ(last.level, Log::WARN);
  EXPECT_EQ(last.msg, std::to_string(kLines - came) +
                          " log lines were not published on /rosout: they came faster than they could be published");
  log.info("again");
  EXPECT_EQ(lines.next().msg, "again");
}

std::uint64_t memory_for_a_line() {
  const Logger log{"noisy"};
  log.info("{} {}", "warm", std::string(100, 'x'));
  const std::string text(100, 'x');
  const nacelle::test::AllocationGuard heap;
  log.info("{} {}", "counted", text);
  return heap.count();
}

TEST(Rosout, allocates_nothing_on_the_logging_thread) {
  const std::uint64_t before = memory_for_a_line();
  const SystemClock clock;
  Broker broker{clock};
  Executor executor{"services", clock, {.own = true}};
  NodeGroups node{executor, "/test", [](const std::string&, const std::string&, const std::string&) {}};
  CallbackGroup group{node};
  const Rosout rosout{group, broker, clock, "/test"};
  executor.open(node);
  EXPECT_EQ(memory_for_a_line(), before);
}

TEST(LogQueue, costs_the_writer_no_memory_and_gives_back_what_was_written) {
  LogQueue queue;
  const std::string too_long = std::string(LogQueue::kLongestText - 1, 'a') + "\xC3\xA4" + "rest";
  {
    const nacelle::test::AllocationGuard heap;
    EXPECT_TRUE(queue.push(LogLevel::Error, WallTime{Duration{1500}}, "lidar", "lost", {"a.cpp", "run", 7}));
    EXPECT_TRUE(queue.push(LogLevel::Info, WallTime{}, "", too_long, {}));
    EXPECT_EQ(heap.count(), 0U);
  }
  std::vector<std::string> told;
  EXPECT_EQ(queue.take([&](const LogQueue::Line& line) {
    told.push_back(std::string{line.name} + "|" + std::string{line.text} + "|" + std::string{line.file} + "|" +
                   std::string{line.function} + "|" + std::to_string(line.number) + "|" +
                   std::to_string(line.when.nanoseconds()));
  }),
            0U);
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0], "lidar|lost|a.cpp|run|7|1500");
  EXPECT_EQ(told[1], "|" + std::string(LogQueue::kLongestText - 1, 'a') + "|||0|0")
      << "cut before a character, not in it";
}

TEST(LogQueue, keeps_what_is_older_and_counts_what_it_drops) {
  LogQueue queue;
  const std::string text(1000, 'x');
  std::uint64_t taken = 0, dropped = 0;
  for (int i = 0; i < 100; ++i) ++(queue.push(LogLevel::Info, WallTime{}, "a", text, {}) ? taken : dropped);
  EXPECT_GT(taken, 20U);
  std::uint64_t shown = 0;
  EXPECT_EQ(queue.take([&](const LogQueue::Line&) { ++shown; }), dropped);
  EXPECT_EQ(shown, taken);
  EXPECT_TRUE(queue.push(LogLevel::Info, WallTime{}, "a", text, {}));
  EXPECT_EQ(queue.take([](const LogQueue::Line&) {}), 0U);
}

}  // namespace
}  // namespace nacelle::runtime
