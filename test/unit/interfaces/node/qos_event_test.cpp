// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <std_msgs/msg/header.hpp>
#include <std_msgs/msg/string.hpp>

#include "nacelle/node/node.hpp"
#include "support/recording_host.hpp"

namespace nacelle {
namespace {

using std_msgs::msg::String;

struct QosEventTest : ::testing::Test {
  test::RecordingContext context;
  Node sender{"sender", NodeOptions{context}};
  Node receiver{"receiver", NodeOptions{context}};
  static void ignore(const String&) {}
};

TEST_F(QosEventTest, a_missed_deadline_calls_both_sides_with_total_and_change) {
  std::vector<std::uint64_t> offered, requested;
  PublisherOptions publisher_options;
  publisher_options.event_callbacks.deadline_callback = [&](QOSDeadlineOfferedInfo& info) {
    offered.push_back(info.total_count);
  };
  SubscriptionOptions subscription_options;
  subscription_options.event_callbacks.deadline_callback = [&](QOSDeadlineRequestedInfo& info) {
    EXPECT_EQ(info.total_count_change, 1U);
    requested.push_back(info.total_count);
  };
  auto publisher = sender.create_publisher<String>("t", QoS(1).deadline(10ms), publisher_options);
  auto subscription = receiver.create_subscription<String>("t", QoS(1).deadline(10ms), &ignore, subscription_options);
  publisher->publish(String{});
  context.advance(10ms);
  EXPECT_TRUE(offered.empty());
  context.advance(20ms);
  EXPECT_EQ(offered, (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(requested, (std::vector<std::uint64_t>{1, 2}));
}

TEST_F(QosEventTest, reports_liveliness_as_lost_and_as_changed) {
  int lost = 0;
  std::vector<std::pair<std::uint32_t, std::int32_t>> alive;
  PublisherOptions publisher_options;
  publisher_options.event_callbacks.liveliness_callback = [&](QOSLivelinessLostInfo& info) {
    lost += static_cast<int>(info.total_count_change);
  };
  SubscriptionOptions subscription_options;
  subscription_options.event_callbacks.liveliness_callback = [&](QOSLivelinessChangedInfo& info) {
    alive.emplace_back(info.alive_count, info.alive_count_change);
  };
  const QoS manual = QoS(1).liveliness(Liveliness::ManualByTopic).liveliness_lease_duration(10ms);
  auto publisher = sender.create_publisher<String>("t", manual, publisher_options);
  auto subscription = receiver.create_subscription<String>("t", manual, &ignore, subscription_options);
  context.advance(15ms);
  publisher->assert_liveliness();
  context.advance(5ms);
  EXPECT_EQ(lost, 1);
  EXPECT_EQ(alive, (std::vector<std::pair<std::uint32_t, std::int32_t>>{{1, 1}, {0, -1}, {1, 1}}));
}

TEST_F(QosEventTest, reports_an_incompatible_publisher_with_its_policy_and_the_change) {
  QOSRequestedIncompatibleQoSInfo told;
  SubscriptionOptions options;
  options.event_callbacks.incompatible_qos_callback = [&](QOSRequestedIncompatibleQoSInfo& info) { told = info; };
  auto subscription = receiver.create_subscription<String>("t", QoS(1).reliable(), &ignore, options);
  auto publisher = sender.create_publisher<String>("t", QoS(1).best_effort());
  EXPECT_EQ(told.total_count, 1U);
  EXPECT_EQ(told.last_policy_kind, "reliability");
  EXPECT_NE(told.text.find("/sender"), std::string::npos) << told.text;
}

TEST_F(QosEventTest, reports_another_type) {
  IncompatibleTypeInfo told;
  SubscriptionOptions options;
  options.event_callbacks.incompatible_type_callback = [&](IncompatibleTypeInfo& info) { told = info; };
  auto subscription = receiver.create_subscription<String>("t", QoS(1), &ignore, options);
  auto publisher = sender.create_publisher<std_msgs::msg::Header>("t", QoS(1));
  context.advance(1ms);
  EXPECT_EQ(told.total_count, 1U);
  EXPECT_EQ(told.last_policy_kind, "type");
}

TEST_F(QosEventTest, reports_matches_and_lost_messages) {
  std::vector<std::uint32_t> matched;
  std::uint64_t lost = 0;
  SubscriptionOptions options;
  options.event_callbacks.matched_callback = [&](MatchedInfo& info) { matched.push_back(info.current_count); };
  options.event_callbacks.message_lost_callback = [&](QOSMessageLostInfo& info) { lost = info.total_count; };
  auto subscription = receiver.create_subscription<String>("t", QoS(1), &ignore, options);
  auto publisher = sender.create_publisher<String>("t", QoS(1));
  for (int i = 0; i < 3; ++i) publisher->publish(String{});
  EXPECT_EQ(lost, 2U);
  publisher.reset();
  context.advance(1ms);
  EXPECT_EQ(matched, (std::vector<std::uint32_t>{1, 0}));
}

}  // namespace
}  // namespace nacelle
