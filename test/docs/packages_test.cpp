// SPDX-License-Identifier: Apache-2.0
// The packages of docs/examples/packages, built as their reader builds them, loaded into a container and run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <condition_variable>
#include <functional>
#include <mutex>
#include <sensor_msgs/msg/range.hpp>
#include <std_msgs/msg/bool.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_msgs/msg/string.hpp>
#include <std_msgs/msg/u_int64.hpp>
#include <std_srvs/srv/trigger.hpp>

#include "nacelle/io/pty_pair.hpp"
#include "nacelle/runtime/container.hpp"
#include "support/ear.hpp"
#include "support/places.hpp"

namespace nacelle {
namespace {

using sensor_msgs::msg::Range;
using std_msgs::msg::Bool;
using std_msgs::msg::Float64;
using std_msgs::msg::UInt64;
using std_srvs::srv::Trigger;

class ExamplePackages : public ::testing::Test {
 protected:
  static runtime::ContainerOptions options() {
    runtime::ContainerOptions options;
    options.component_path = {test::component_folder()};
    return options;
  }
  std::uint64_t start(const std::string& plugin, std::map<std::string, ParameterValue> parameters = {}) {
    runtime::LoadRequest request;
    request.plugin = "example::" + plugin;
    request.parameters = std::move(parameters);
    const auto loaded = container_.load(request);
    EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().text());
    if (!loaded) return 0;
    for (const Transition step : {Transition::Configure, Transition::Activate})
      EXPECT_EQ(container_.trigger(loaded.value().id, step).reason, "");
    return loaded.value().id;
  }
  void say(double value) {
    if (!mouth_) mouth_ = container_.transport().create_writer({"/raw", &Float64::message_type(), QoS(10), "/mouth"});
    Block* const block = mouth_->borrow();
    static_cast<Float64*>(block->message)->data = value;
    mouth_->publish(*block);
  }

  SystemClock clock_;
  runtime::Container container_{options(), clock_};
  std::unique_ptr<Writer> mouth_;
};

TEST_F(ExamplePackages, talker_and_listener_talk) {
  test::Ear<UInt64> heard{container_.transport(), "/heard", QoS(10)};
  start("Listener");
  start("Talker", {{"period", 0.01}});
  EXPECT_EQ(heard.next().data, 1U);
  EXPECT_EQ(heard.next().data, 2U);
}

TEST_F(ExamplePackages, mean_filter_publishes_the_mean_of_its_window_and_clears_it_on_request) {
  test::Ear<Float64> mean{container_.transport(), "/mean", QoS(10)};
  start("MeanFilter", {{"window", std::int64_t{2}}});
  for (const auto& [value, expected] : {std::pair{1.0, 1.0}, {3.0, 2.0}, {5.0, 4.0}}) {
    say(value);
    EXPECT_EQ(mean.next().data, expected);
  }
  std::mutex mutex;
  std::condition_variable answered;
  bool is_answered = false;
  Trigger::Request request;
  const auto call = container_.call_service("/mean_filter/reset", Trigger::service_type(), &request, [&] {
    const std::lock_guard lock(mutex);
    is_answered = true;
    answered.notify_all();
  });
  ASSERT_TRUE(call) << call.error().text();
  {
    std::unique_lock lock(mutex);
    ASSERT_TRUE(answered.wait_for(lock, 20s, [&] { return is_answered; }));
  }
  say(7.0);
  EXPECT_EQ(mean.next().data, 7.0);
}

TEST_F(ExamplePackages, blinker_changes_its_led_at_a_rate_that_may_be_set) {
  test::Ear<Bool> led{container_.transport(), "/led", QoS(1000)};
  const auto id = start("Blinker", {{"rate", 10.0}});
  EXPECT_TRUE(led.next().data);
  EXPECT_FALSE(led.next().data);
  EXPECT_TRUE(led.next().data);
  EXPECT_EQ(container_.trigger(id, Transition::Deactivate).reason, "");
}

TEST_F(ExamplePackages, range_driver_reads_a_line_and_outlives_its_cable) {
  auto cable = io::PtyPair::create();
  ASSERT_TRUE(cable);
  const std::string path = ::testing::TempDir() + "range_driver_" + std::to_string(::getpid());
  ASSERT_TRUE(cable.value()->link_as(path));
  test::Ear<Range> ranges{container_.transport(), "/range", QoS(5).best_effort()};
  start("RangeDriver", {{"port_name", path}});
  ASSERT_NE(cable.value()->write_some(as_bytes("34\n12x4\n1234\n")), 0U);
  const Range range = ranges.next();
  EXPECT_FLOAT_EQ(range.range, 1.234F);
  EXPECT_EQ(range.header.frame_id, "range_link");
  EXPECT_NE(range.header.stamp.sec, 0);

  cable.value()->hang_up();
  cable = io::PtyPair::create();
  ASSERT_TRUE(cable);
  ASSERT_TRUE(cable.value()->link_as(path));
  // What comes before the driver has opened the line again is lost, as from a real device.
  do { static_cast<void>(cable.value()->write_some(as_bytes("500\n"))); } while (!ranges.waits(50ms));
  EXPECT_FLOAT_EQ(ranges.next().range, 0.5F);
  EXPECT_EQ(container_.find("range_driver").value().state, StateId::Active);
}

}  // namespace
}  // namespace nacelle
