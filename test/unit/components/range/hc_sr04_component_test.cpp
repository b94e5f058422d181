// SPDX-License-Identifier: Apache-2.0
#include "range/component/hc_sr04_component.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>

#include "range/port/scripted_echo_lines.hpp"
#include "support/recording_host.hpp"

namespace nacelle::range {
namespace {

using sensor_msgs::msg::Range;
using test::RecordingContext;

/// The pace of the thread is real (as fast as `rate` allows); the time of the measurements is told.
class HcSr04ComponentTest : public ::testing::Test {
 protected:
  HcSr04Component& make(std::map<std::string, ParameterValue> overrides = {}) {
    overrides.insert({{"rate", 20.0}, {"gpio_chip", std::string{"/dev/no_gpiochip"}}});
    NodeOptions options{context_};
    options.parameter_overrides(std::move(overrides));
    component_ = std::make_unique<HcSr04Component>(
        options, [this](const EchoSettings&, const Clock& clock) -> Result<std::unique_ptr<EchoLines>, Problem> {
          if (absent_) return err(Problem{"GPIO lines", "no such chip", ""});
          auto lines = std::make_unique<ScriptedEchoLines>(clock, [this](MonotonicTime until) {
            if (until > context_.clock().now()) context_.clock().advance(until - context_.clock().now());
          });
          lines->answer(pulse_);
          lines_ = lines.get();
          return std::unique_ptr<EchoLines>{std::move(lines)};
        });
    return *component_;
  }
  void bring_up(HcSr04Component& range) {
    const auto configured = range.trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    ASSERT_TRUE(range.trigger(Transition::Activate).success);
  }

  RecordingContext context_;
  std::atomic<bool> absent_{false};
  std::optional<Duration> pulse_ = 5831us;
  std::atomic<ScriptedEchoLines*> lines_{nullptr};
  std::unique_ptr<HcSr04Component> component_;
};

TEST_F(HcSr04ComponentTest, publishes_ranges_with_every_field_set) {
  HcSr04Component& range = make();
  bring_up(range);
  ASSERT_TRUE(context_.wait_for("/range", 2));
  const Range message = context_.published<Range>("/range").front();
  EXPECT_EQ(message.header.frame_id, "range_link");
  EXPECT_EQ(message.radiation_type, Range::ULTRASOUND);
  EXPECT_FLOAT_EQ(message.field_of_view, 0.26F);
  EXPECT_FLOAT_EQ(message.min_range, 0.02F);
  EXPECT_FLOAT_EQ(message.max_range, 4.0F);
  EXPECT_NEAR(message.range, 1.0, 0.002);
  ASSERT_TRUE(range.trigger(Transition::Deactivate).success);
  const int triggers = lines_.load()->triggers();
  ASSERT_TRUE(range.trigger(Transition::Activate).success);
  ASSERT_TRUE(range.trigger(Transition::Deactivate).success);
  EXPECT_GE(lines_.load()->triggers(), triggers) << "only an active node triggers";
  ASSERT_TRUE(range.trigger(Transition::Cleanup).success);
}

TEST_F(HcSr04ComponentTest, an_empty_room_is_infinite_and_no_fault) {
  pulse_ = 38ms;
  HcSr04Component& range = make();
  bring_up(range);
  ASSERT_TRUE(context_.wait_for("/range", 3));
  EXPECT_EQ(context_.published<Range>("/range").back().range, std::numeric_limits<float>::infinity());
  EXPECT_TRUE(context_.open_faults().empty());
}

TEST_F(HcSr04ComponentTest, a_sensor_that_does_not_answer_is_an_open_fault_until_it_does) {
  HcSr04Component& range = make();
  bring_up(range);
  ASSERT_TRUE(context_.wait_for("/range", 1));
  lines_.load()->answer(std::nullopt);
  context_.clock().advance(1s);
  context_.wait_for_open_faults(1);
  EXPECT_EQ(context_.open_faults()[0].code, kDeviceLost);
  EXPECT_NE(context_.open_faults()[0].text.find("does not answer its trigger"), std::string::npos);
  lines_.load()->answer(1ms);
  context_.wait_for_open_faults(0);
  EXPECT_EQ(range.get_current_state().state(), StateId::Active);
}

TEST_F(HcSr04ComponentTest, a_chip_that_is_gone_is_opened_again) {
  HcSr04Component& range = make();
  bring_up(range);
  ASSERT_TRUE(context_.wait_for("/range", 1));
  absent_ = true;
  lines_.load()->lose();
  context_.wait_for_open_faults(1);
  absent_ = false;
  context_.wait_for_open_faults(0);
}

TEST_F(HcSr04ComponentTest, comes_up_without_its_chip) {
  absent_ = true;
  HcSr04Component& range = make();
  bring_up(range);
  ASSERT_EQ(context_.open_faults().size(), 1U) << "reported before the bring-up continues";
  absent_ = false;
  ASSERT_TRUE(context_.wait_for("/range", 1));
  context_.wait_for_open_faults(0);
}

std::string refusal_of(const std::map<std::string, ParameterValue>& overrides) {
  RecordingContext context;
  NodeOptions options{context};
  options.parameter_overrides(overrides);
  HcSr04Component range{options};
  const auto outcome = range.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  return outcome.reason;
}

TEST(HcSr04Parameters, what_is_wrong_is_named_with_the_way_out) {
  const std::string absent = refusal_of({{"gpio_chip", std::string{"/dev/no_gpiochip"}}, {"required_device", true}});
  EXPECT_NE(absent.find("GPIO lines 23, 24 of /dev/no_gpiochip"), std::string::npos) << absent;
  EXPECT_NE(refusal_of({{"echo_line", std::int64_t{23}}}).find("23 is trigger_line, too"), std::string::npos);
  EXPECT_NE(refusal_of({{"min_range", 5.0}}).find("max_range"), std::string::npos);
}

}  // namespace
}  // namespace nacelle::range
