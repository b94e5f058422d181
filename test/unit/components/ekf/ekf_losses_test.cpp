// SPDX-License-Identifier: Apache-2.0
// What the queue in front of the filter loses.
#include <gtest/gtest.h>

#include <algorithm>

#include "ekf_cases.hpp"
#include "ekf_node.hpp"
#include "support/log_lines.hpp"

namespace nacelle::ekf {
namespace {

using nav_msgs::msg::Odometry;

/// A filter that keeps three messages of `odom` until its callback runs, and publishers that do not wait for it.
class EkfQueue : public EkfNode {
 public:
  using Wheels = Publisher<Odometry>::SharedPtr;
  EkfQueue() {
    options_.append_parameter_override("odom0", std::string{"odom"});
    options_.append_parameter_override("odom0_config", config_of({kVx}));
    options_.append_parameter_override("odom0_queue_size", std::int64_t{3});
    options_.append_parameter_override("print_diagnostics", true);
  }
  Wheels wheels() { return probe_.create_publisher<Odometry>("odom", QoS(10)); }
  void send(const Wheels& wheels, int messages) {
    for (int i = 0; i < messages; ++i) {
      auto message = wheels->borrow();
      *message = odometry(0.3);
      wheels->publish(std::move(message));
    }
  }
  /// What /diagnostics says that was lost of odom0.
  std::string lost() {
    context_.advance(1020ms);
    const auto all = context_.published<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics");
    if (all.empty()) return "nothing is published";
    for (const auto& pair : all.back().status.at(0).values) {
      if (pair.key == "lost") return pair.value;
    }
    return "no such key";
  }

 private:
  Node probe_{"probe", NodeOptions{context_}};
};

TEST_F(EkfQueue, messages_that_the_subscription_drops_are_counted_and_reported) {
  start();
  const test::LogLines lines;
  const Wheels sender = wheels();
  send(sender, 1);
  context_.spin();
  send(sender, 8);  // all before the callback runs; the queue keeps three
  context_.spin();

  EXPECT_EQ(lost(), "5");

  EXPECT_EQ(node_->stats("odom0 twist")->received, 4U);
  EXPECT_TRUE(std::any_of(lines.all.begin(), lines.all.end(), [](const std::string& line) {
    return line.find(
               "odom0: 5 measurements were lost (5 in all: 5 in the subscription's queue, see odom0_queue_size") !=
           std::string::npos;
  })) << ::testing::PrintToString(lines.all);
}

TEST_F(EkfQueue, losses_are_seen_when_two_publishers_alternate) {
  start();
  const Wheels left = wheels(), right = wheels();
  for (int i = 0; i < 10; ++i) {
    send(i % 2 == 0 ? left : right, 1);
    context_.spin();
  }
  EXPECT_EQ(lost(), "0") << "each counts for itself";

  for (int i = 0; i < 8; ++i) send(i % 2 == 0 ? left : right, 1);
  context_.spin();

  EXPECT_EQ(lost(), "5");
}

TEST_F(EkfQueue, losses_are_seen_behind_any_number_of_publishers_that_are_gone) {
  start();
  for (std::size_t i = 0; i < 3 * Input::kMostWriters; ++i) {
    send(wheels(), 1);
    context_.spin();
  }
  const Wheels last = wheels();
  send(last, 1);
  context_.spin();
  send(last, 4);
  context_.spin();

  EXPECT_EQ(lost(), "1");
}

TEST_F(EkfQueue, messages_that_are_sent_while_it_is_inactive_are_no_loss) {
  start();
  const Wheels sender = wheels();
  send(sender, 1);
  context_.spin();
  ASSERT_TRUE(node_->trigger(Transition::Deactivate).success);
  send(sender, 8);
  context_.spin();
  ASSERT_TRUE(node_->trigger(Transition::Activate).success);
  send(sender, 2);
  context_.spin();

  EXPECT_EQ(lost(), "0");
}

}  // namespace
}  // namespace nacelle::ekf
