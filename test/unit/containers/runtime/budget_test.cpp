// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/budget.hpp"

#include <gtest/gtest.h>

#include <std_msgs/msg/string.hpp>

#include "nacelle/runtime/container.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::runtime {
namespace {

using std_msgs::msg::String;

struct BudgetTest : ::testing::Test {
  test::ManualClock clock;
  Container container{ContainerOptions{}, clock};

  static EndpointSpec spec(const std::string& node) { return {"/chat", &String::message_type(), QoS(100), node}; }
  std::unique_ptr<Writer> writer = container.transport().create_writer(spec("/sender"));

  void send(int messages) {
    for (int i = 0; i < messages; ++i) static_cast<void>(writer->publish(*writer->borrow()));
  }
  static StreamBudget of_chat() {
    StreamBudget budget;
    budget.where = "robot.launch.yaml:7";
    budget.topic = "/chat";
    return budget;
  }
  std::vector<BudgetEvent> after(BudgetWatch& watch, Duration time) {
    clock.advance(time);
    return watch.look(container, clock.now());
  }
};

TEST_F(BudgetTest, a_wiring_that_must_copy_is_refused_with_the_owner_named) {
  auto budget = of_chat();
  budget.max_copies = 0;
  const BudgetWatch watch{{budget}};
  auto owner = container.transport().create_reader(spec("/owner"), Taking::Own, nullptr);
  EXPECT_TRUE(watch.check_wiring(container).empty()) << "one owner gets the original";
  auto reader = container.transport().create_reader(spec("/reader"), Taking::Share, nullptr);
  const auto problems = watch.check_wiring(container);
  ASSERT_EQ(problems.size(), 1U);
  for (const char* part : {"robot.launch.yaml:7", "/chat", "/owner", "const T&"})
    EXPECT_NE(problems[0].text().find(part), std::string::npos) << problems[0].text();
  // What was foretold is what happens.
  send(3);
  EXPECT_EQ(writer->counters().copies, 3U);
}

TEST_F(BudgetTest, reports_a_rate_below_the_limit_once_and_its_return) {
  auto budget = of_chat();
  budget.min_hz = 10;
  BudgetWatch watch{{budget}};
  EXPECT_TRUE(watch.look(container, clock.now()).empty());
  send(10);
  EXPECT_TRUE(after(watch, 1s).empty());
  send(5);
  const auto broken = after(watch, 1s);
  ASSERT_EQ(broken.size(), 1U);
  EXPECT_TRUE(broken[0].broken);
  EXPECT_NE(broken[0].text().find("5 messages in 1.0 s"), std::string::npos) << broken[0].text();
  EXPECT_TRUE(after(watch, 1s).empty()) << "it is still broken";
  send(10);
  const auto kept = after(watch, 1s);
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_FALSE(kept[0].broken);
  writer.reset();
  const auto gone = after(watch, 1s);
  ASSERT_EQ(gone.size(), 1U);
  EXPECT_NE(gone[0].cause.find("no publisher is loaded"), std::string::npos);
}

TEST_F(BudgetTest, messages_that_wait_too_long_break_the_age) {
  auto budget = of_chat();
  budget.max_age = 50ms;
  BudgetWatch watch{{budget}};
  auto reader = container.transport().create_reader(spec("/reader"), Taking::Share, nullptr);
  EXPECT_TRUE(watch.look(container, clock.now()).empty());
  reader->note_latency(40ms);
  EXPECT_TRUE(after(watch, 1s).empty());
  reader->note_latency(80ms);
  const auto broken = after(watch, 1s);
  ASSERT_EQ(broken.size(), 1U);
  EXPECT_EQ(broken[0].limit, "max_age 50ms");
  reader->note_latency(1ms);
  EXPECT_EQ(after(watch, 1s).size(), 1U) << "kept again";
}

}  // namespace
}  // namespace nacelle::runtime
