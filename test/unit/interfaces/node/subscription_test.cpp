// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <functional>
#include <std_msgs/msg/string.hpp>

#include "nacelle/node/node.hpp"
#include "support/recording_host.hpp"

namespace nacelle {
namespace {

using std_msgs::msg::String;

struct SubscriptionTest : ::testing::Test {
  test::RecordingContext context;
  Node node{"node", NodeOptions{context}};
  String hello = [] {
    String message;
    message.data = "hello";
    return message;
  }();
};

TEST_F(SubscriptionTest, the_callbacks_parameter_is_the_wish) {
  std::string by_reference, by_pointer, by_loan, by_unique;
  std::uint64_t sequence = 0;
  std::shared_ptr<const String> kept;
  auto a = node.create_subscription<String>("t", QoS(1), [&](const String& m) { by_reference = m.data; });
  auto b = node.create_subscription<String>("t", QoS(1), [&](std::shared_ptr<const String> m, const MessageInfo& info) {
    by_pointer = m->data;
    sequence = info.sequence;
    kept = std::move(m);
  });
  auto c = node.create_subscription<String>("t", QoS(1), [&](Loan<String> m) {
    by_loan = m->data;
    m->data = "changed by its owner";
  });
  auto d = node.create_subscription<String>("t", QoS(1), [&](std::unique_ptr<String> m) { by_unique = m->data; });
  context.inject("/t", hello);
  for (const auto& text : {by_reference, by_pointer, by_loan, by_unique}) EXPECT_EQ(text, "hello");
  EXPECT_EQ(sequence, 1U);
  EXPECT_EQ(kept->data, "hello");
  EXPECT_EQ(d->counters().rehomed, 1U);
  EXPECT_EQ(a->counters().rehomed, 0U);
}

struct Hearer {
  void by_reference(const String& message) { heard += "reference " + message.data + "\n"; }
  void by_pointer(String::ConstSharedPtr message) { heard += "pointer " + message->data + "\n"; }
  void with_info(const String& message, const MessageInfo& info) {
    heard += "info " + message.data + " " + std::to_string(info.sequence) + "\n";
  }
  void as_owner(Loan<String> message) { heard += "loan " + message->data + "\n"; }
  void as_unique(String::UniquePtr message) { heard += "unique " + message->data + "\n"; }
  std::string heard;
};

TEST_F(SubscriptionTest, callables_without_one_signature_are_called_with_what_they_take) {
  using namespace std::placeholders;
  Hearer hearer;
  const auto a = node.create_subscription<String>("t", QoS(1), std::bind(&Hearer::by_reference, &hearer, _1));
  const auto b = node.create_subscription<String>("t", QoS(1), std::bind(&Hearer::by_pointer, &hearer, _1));
  const auto c = node.create_subscription<String>("t", QoS(1), std::bind(&Hearer::with_info, &hearer, _1, _2));
  const auto d = node.create_subscription<String>("t", QoS(1), std::bind(&Hearer::as_owner, &hearer, _1));
  const auto e = node.create_subscription<String>("t", QoS(1), std::bind(&Hearer::as_unique, &hearer, _1));
  const auto f =
      node.create_subscription<String>("t", QoS(1), [&](const auto& m) { hearer.heard += "auto " + m.data + "\n"; });
  context.inject("/t", hello);
  for (const char* line :
       {"reference hello\n", "pointer hello\n", "info hello 1\n", "loan hello\n", "unique hello\n", "auto hello\n"})
    EXPECT_NE(hearer.heard.find(line), std::string::npos) << line << "in\n" << hearer.heard;
}

TEST_F(SubscriptionTest, a_std_function_and_a_pointer_that_may_write_work_as_in_rclcpp) {
  std::string by_function, by_pointer;
  const std::function<void(const String&)> function = [&](const String& m) { by_function = m.data; };
  const auto a = node.create_subscription<String>("t", QoS(1), function);
  String::SharedPtr kept;
  const auto b = node.create_subscription<String>("t", QoS(1), [&](const String::SharedPtr m) {
    m->data += ", changed by its owner";
    kept = m;
  });
  context.inject("/t", hello);
  EXPECT_EQ(by_function, "hello");
  EXPECT_EQ(kept->data, "hello, changed by its owner");
}

TEST_F(SubscriptionTest, a_wish_is_read_from_the_exact_type) {
  using detail::kTaking;
  static_assert(kTaking<String, const String&> == Taking::Share);
  static_assert(kTaking<String, std::shared_ptr<const String>> == Taking::Share);
  static_assert(kTaking<String, const std::shared_ptr<const String>&> == Taking::Share);
  static_assert(kTaking<String, Loan<String>> == Taking::Own);
  static_assert(kTaking<String, std::shared_ptr<String>> == Taking::Own);
  static_assert(kTaking<String, std::unique_ptr<String>> == Taking::Own);
  static_assert(sizeof(Loan<String>) == 2 * sizeof(void*));
}

TEST_F(SubscriptionTest, three_ways_to_publish_deliver_the_same) {
  auto publisher = node.create_publisher<String>("out", QoS(10));
  auto loan = publisher->borrow();
  *loan = hello;
  publisher->publish(std::move(loan));
  publisher->publish(std::make_unique<String>(hello));
  publisher->publish(hello);
  const auto all = context.published<String>("/out");
  ASSERT_EQ(all.size(), 3U);
  for (const auto& message : all) EXPECT_EQ(message, hello);
}

TEST_F(SubscriptionTest, names_are_expanded_remapped_and_checked) {
  Node arm{"arm",
           NodeOptions{context}.node_namespace("/robot1").remap_rules({make_remap_rule("in", "/elsewhere").value()})};
  EXPECT_EQ(arm.get_fully_qualified_name(), "/robot1/arm");
  EXPECT_EQ(arm.resolve_topic_name("~/state"), "/robot1/arm/state");
  EXPECT_EQ(arm.resolve_topic_name("in"), "/elsewhere");
  EXPECT_THROW((void)arm.resolve_topic_name("bad name"), exceptions::InvalidNameError);
  EXPECT_THROW((Node{"4bad", NodeOptions{context}}), exceptions::InvalidNameError);
}

TEST_F(SubscriptionTest, the_launch_files_qos_wins) {
  Node tuned{"tuned",
             NodeOptions{context}.qos_overrides({{"scan", true, [](const QoS& q) { return QoS(q).best_effort(); }}})};
  EXPECT_EQ(tuned.create_publisher<String>("scan", QoS(3))->get_actual_qos().reliability(), Reliability::BestEffort);
  EXPECT_EQ(tuned.create_publisher<String>("other", QoS(3))->get_actual_qos().reliability(), Reliability::Reliable);
}

}  // namespace
}  // namespace nacelle
