// SPDX-License-Identifier: Apache-2.0
// Packages of docs/examples/packages together, and what their own tests leave out.
#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>
#include <std_msgs/msg/bool.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_msgs/msg/u_int64.hpp>
#include <std_srvs/srv/trigger.hpp>

#include "nacelle/runtime/test_container.hpp"

namespace nacelle {
namespace {

using std_msgs::msg::Bool;
using std_msgs::msg::Float64;
using std_msgs::msg::UInt64;
using std_srvs::srv::Trigger;

TEST(ExamplePackages, talker_and_listener_talk) {
  runtime::TestContainer container;
  auto heard = container.subscribe<UInt64>("/heard", QoS(10));
  container.start("example::Listener");
  container.start("example::Talker", {{"period", 0.01}});
  EXPECT_EQ(heard.next().data, 1U);
  EXPECT_EQ(heard.next().data, 2U);
}

TEST(ExamplePackages, mean_filter_clears_its_values_on_request) {
  runtime::TestContainer container;
  auto mean = container.subscribe<Float64>("/mean", QoS(10));
  auto raw = container.advertise<Float64>("/raw", QoS(10));
  container.start("example::MeanFilter");
  raw.publish({.data = 5.0});
  EXPECT_EQ(mean.next().data, 5.0);
  std::mutex mutex;
  std::condition_variable answered;
  bool is_answered = false;
  Trigger::Request request;
  const auto call = container.container().call_service("/mean_filter/reset", Trigger::service_type(), &request, [&] {
    const std::lock_guard lock(mutex);
    is_answered = true;
    answered.notify_all();
  });
  ASSERT_TRUE(call) << call.error().text();
  {
    std::unique_lock lock(mutex);
    ASSERT_TRUE(answered.wait_for(lock, 20s, [&] { return is_answered; }));
  }
  raw.publish({.data = 7.0});
  EXPECT_EQ(mean.next().data, 7.0);
}

TEST(ExamplePackages, blinker_changes_its_led_at_a_rate_that_may_be_set) {
  runtime::TestContainer container;
  auto led = container.subscribe<Bool>("/led", QoS(1000));
  const auto blinker = container.start("example::Blinker", {{"rate", 10.0}});
  EXPECT_TRUE(led.next().data);
  EXPECT_FALSE(led.next().data);
  EXPECT_TRUE(led.next().data);
  EXPECT_EQ(container.container().trigger(blinker.id, Transition::Deactivate).reason, "");
}

}  // namespace
}  // namespace nacelle
