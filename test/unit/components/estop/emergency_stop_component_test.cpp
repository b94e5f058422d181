// SPDX-License-Identifier: Apache-2.0
#include "estop/component/emergency_stop_component.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "estop/port/scripted_switch.hpp"
#include "support/recording_host.hpp"

namespace nacelle::estop {
namespace {

using std_msgs::msg::Bool;
using std_srvs::srv::SetBool;
using ::testing::HasSubstr;

/// The component with a button that the test presses; its thread lives in real time.
class EmergencyStopTest : public ::testing::Test {
 protected:
  NodeOptions with_a_button() {
    NodeOptions options{context_};
    options.append_parameter_override("gpio_chip", std::string("/dev/gpiochip0"));
    return options;
  }
  EmergencyStopComponent::OpenSwitch opener() {
    return [this](const GpioSettings&, const Clock&) -> Result<std::unique_ptr<SwitchPort>, Problem> {
      if (is_away_) return err(Problem{"the button", "no such chip", ""});
      auto made = std::make_unique<ScriptedSwitch>();
      button_ = made.get();
      if (pressed_at_first_) button_->press(true);
      return std::unique_ptr<SwitchPort>{std::move(made)};
    };
  }
  static void activate(EmergencyStopComponent& stop) {
    ASSERT_TRUE(stop.trigger(Transition::Configure).success);
    ASSERT_TRUE(stop.trigger(Transition::Activate).success);
  }
  std::vector<bool> said() {
    std::vector<bool> all;
    for (const auto& message : context_.published<Bool>("/emergency_stop")) all.push_back(message.data);
    return all;
  }
  static Bool release() {
    Bool message;
    message.data = false;
    return message;
  }

  SystemClock clock_;
  test::RecordingContext context_{clock_};
  ScriptedSwitch* button_ = nullptr;
  bool pressed_at_first_ = false;
  std::atomic<bool> is_away_{false};
};

TEST_F(EmergencyStopTest, the_service_sets_and_releases) {
  EmergencyStopComponent stop{NodeOptions{context_}, opener()};
  activate(stop);
  SetBool::Request request;
  SetBool::Response response;
  request.data = true;
  ASSERT_TRUE(context_.call<SetBool>("/estop/set", request, response));
  EXPECT_TRUE(response.success);
  request.data = false;
  ASSERT_TRUE(context_.call<SetBool>("/estop/set", request, response));
  EXPECT_TRUE(response.success);
  EXPECT_EQ(said(), (std::vector<bool>{true, false}));
  EXPECT_EQ(button_, nullptr) << "no chip is named, so no line is opened";
}

TEST_F(EmergencyStopTest, a_pressed_button_sets_and_letting_go_releases_nothing) {
  EmergencyStopComponent stop{with_a_button(), opener()};
  activate(stop);
  button_->press(true);
  ASSERT_TRUE(context_.wait_for("/emergency_stop", 1));
  button_->press(false);
  button_->press(true);
  button_->press(false);
  ASSERT_TRUE(stop.trigger(Transition::Deactivate).success);
  for (const bool set : said()) EXPECT_TRUE(set);
}

TEST_F(EmergencyStopTest, a_short_press_between_two_reads_sets_the_stop) {
  EmergencyStopComponent stop{with_a_button(), opener()};
  activate(stop);
  button_->press(true);
  button_->press(false);
  ASSERT_TRUE(context_.wait_for("/emergency_stop", 1));
  EXPECT_TRUE(said().front());
}

TEST_F(EmergencyStopTest, a_button_that_is_pressed_when_it_comes_up_stops) {
  pressed_at_first_ = true;
  EmergencyStopComponent stop{with_a_button(), opener()};
  activate(stop);
  // The gate may open after the first attempt; the next look is an interrupt away.
  const auto limit = std::chrono::steady_clock::now() + 10s;
  while (said().empty() && std::chrono::steady_clock::now() < limit) button_->interrupt();
  ASSERT_FALSE(said().empty());
  EXPECT_TRUE(said().front());
}

TEST_F(EmergencyStopTest, refuses_a_release_while_the_button_is_pressed) {
  EmergencyStopComponent stop{with_a_button(), opener()};
  activate(stop);
  button_->press(true);
  ASSERT_TRUE(context_.wait_for("/emergency_stop", 1));
  ASSERT_TRUE(stop.is_pressed());
  SetBool::Request request;
  SetBool::Response response;
  request.data = false;
  ASSERT_TRUE(context_.call<SetBool>("/estop/set", request, response));
  EXPECT_FALSE(response.success);
  EXPECT_THAT(response.message, HasSubstr("button"));

  context_.inject("/emergency_stop", release());
  ASSERT_TRUE(context_.wait_for("/emergency_stop", 3));
  EXPECT_TRUE(said().back());
}

TEST_F(EmergencyStopTest, a_button_that_is_lost_stops_and_is_an_open_fault_until_it_is_back) {
  EmergencyStopComponent stop{with_a_button(), opener()};
  activate(stop);
  is_away_ = true;
  button_->lose();
  ASSERT_TRUE(context_.wait_for("/emergency_stop", 1));
  context_.wait_for_open_faults(1);
  EXPECT_EQ(context_.open_faults()[0].code, kDeviceLost);
  EXPECT_TRUE(stop.is_pressed());
  is_away_ = false;
  context_.wait_for_open_faults(0);
  EXPECT_EQ(stop.get_current_state().state(), StateId::Active);
  EXPECT_EQ(said(), std::vector<bool>{true}) << "the stop was not released";
  EXPECT_TRUE(context_.faults().empty());
}

TEST_F(EmergencyStopTest, comes_up_without_its_chip_and_sets_the_stop) {
  is_away_ = true;
  auto options = with_a_button();
  options.append_parameter_override("gpio_chip", std::string("/dev/no_gpiochip"));
  EmergencyStopComponent stop{options, opener()};
  activate(stop);
  EXPECT_EQ(context_.open_faults().size(), 1U);
  ASSERT_TRUE(context_.wait_for("/emergency_stop", 1));
  EXPECT_TRUE(said().front());
}

TEST_F(EmergencyStopTest, a_required_chip_that_is_absent_fails_the_configuration) {
  is_away_ = true;
  auto options = with_a_button();
  options.append_parameter_override("required_device", true);
  EmergencyStopComponent stop{options, opener()};
  EXPECT_FALSE(stop.trigger(Transition::Configure).success);
}

TEST_F(EmergencyStopTest, with_device_lost_fault_a_button_that_is_lost_stops_and_is_a_fault) {
  auto options = with_a_button();
  options.append_parameter_override("device_lost", std::string("fault"));
  EmergencyStopComponent stop{options, opener()};
  activate(stop);
  button_->lose();
  ASSERT_TRUE(context_.wait_for("/emergency_stop", 1));
  EXPECT_TRUE(said().back());
  const auto limit = std::chrono::steady_clock::now() + 10s;
  while (context_.faults().empty() && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
  ASSERT_EQ(context_.faults().size(), 1U);
  EXPECT_EQ(context_.faults()[0].code, "GPIO_LOST");
}

TEST_F(EmergencyStopTest, a_parameter_that_is_none_is_named) {
  auto options = with_a_button();
  options.append_parameter_override("gpio_stop_level", std::string("hihg"));
  EmergencyStopComponent stop{options, opener()};
  const auto outcome = stop.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_THAT(outcome.reason, HasSubstr("gpio_stop_level"));
  EXPECT_THAT(outcome.reason, HasSubstr("high"));
}

}  // namespace
}  // namespace nacelle::estop
