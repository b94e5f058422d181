// SPDX-License-Identifier: Apache-2.0
#include "joy/component/joy_component.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "joy/port/scripted_pad.hpp"
#include "pads.hpp"
#include "support/recording_host.hpp"

namespace nacelle::joy {
namespace {

using sensor_msgs::msg::Joy;
using test::RecordingContext;

class JoyComponentTest : public ::testing::Test {
 protected:
  JoyComponent& make(std::map<std::string, ParameterValue> overrides = {{"autorepeat_rate", 0.0}}) {
    NodeOptions options{context_};
    options.parameter_overrides(std::move(overrides));
    component_ = std::make_unique<JoyComponent>(options, [this](const JoyOptions&, const Clock&) {
      auto pad = std::make_unique<ScriptedPad>(xbox_pad(), io::ScriptedStream::AtEnd::Blocks);
      pad_ = pad.get();
      if (is_away_) {
        pad->line().start_away();
        pad->line().refuse_reopen(1'000'000);
      }
      return Result<std::unique_ptr<PadPort>, Problem>{std::move(pad)};
    });
    return *component_;
  }
  void bring_up(JoyComponent& joy) {
    const auto configured = joy.trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    ASSERT_TRUE(joy.trigger(Transition::Activate).success);
  }
  void press(unsigned button, int value) {
    Bytes bytes = ScriptedPad::event(context_.clock().now(), EV_KEY, static_cast<std::uint16_t>(button), value);
    const Bytes end = ScriptedPad::event(context_.clock().now(), EV_SYN, SYN_REPORT, 0);
    bytes.insert(bytes.end(), end.begin(), end.end());
    pad_->line().append({{}, bytes, {}});
  }

  RecordingContext context_;
  ScriptedPad* pad_ = nullptr;
  bool is_away_ = false;
  std::unique_ptr<JoyComponent> component_;
};

TEST_F(JoyComponentTest, publishes_what_is_pressed) {
  JoyComponent& joy = make();
  EXPECT_EQ(joy.get_name(), "joy_node");
  bring_up(joy);
  press(BTN_B, 1);
  ASSERT_TRUE(context_.wait_for("/joy", 1));
  EXPECT_EQ(context_.published<Joy>("/joy")[0].buttons[1], 1);
}

TEST_F(JoyComponentTest, an_unplugged_pad_stops_what_it_drives_and_comes_back) {
  JoyComponent& joy = make();
  bring_up(joy);
  press(BTN_B, 1);
  ASSERT_TRUE(context_.wait_for("/joy", 1));
  pad_->line().refuse_reopen(1'000'000);
  pad_->line().append({{}, {}, io::StreamFault::HungUp});
  context_.wait_for_open_faults(1);
  EXPECT_EQ(context_.open_faults()[0].code, kDeviceLost);
  ASSERT_TRUE(context_.wait_for("/joy", 2));
  EXPECT_EQ(context_.published<Joy>("/joy")[1].buttons[1], 0);
  EXPECT_EQ(joy.get_current_state().state(), StateId::Active);

  pad_->line().refuse_reopen(0);
  context_.wait_for_open_faults(0);
  press(BTN_A, 1);
  ASSERT_TRUE(context_.wait_for("/joy", 3));
  EXPECT_EQ(context_.published<Joy>("/joy").size(), 3U);
  EXPECT_TRUE(context_.faults().empty());
}

TEST_F(JoyComponentTest, comes_up_without_its_pad) {
  is_away_ = true;
  JoyComponent& joy = make();
  bring_up(joy);
  ASSERT_EQ(context_.open_faults().size(), 1U) << "reported before the bring-up continues";
  EXPECT_NE(context_.open_faults()[0].text.find("gamepad 0: the device is not there"), std::string::npos)
      << context_.open_faults()[0].text;
  EXPECT_TRUE(context_.published<Joy>("/joy").empty());
  pad_->line().refuse_reopen(0);
  context_.wait_for_open_faults(0);
  press(BTN_A, 1);
  EXPECT_TRUE(context_.wait_for("/joy", 1));
}

TEST_F(JoyComponentTest, with_device_lost_fault_an_absent_pad_is_a_fault) {
  is_away_ = true;
  JoyComponent& joy = make({{"device_lost", std::string{"fault"}}, {"silence_limit", 0.5}});
  bring_up(joy);
  context_.clock().advance(600ms);
  while (context_.faults().empty()) std::this_thread::yield();
  EXPECT_EQ(context_.faults()[0].code, "JOY_ABSENT");
}

TEST_F(JoyComponentTest, can_be_cleaned_up_and_configured_again) {
  JoyComponent& joy = make();
  for (int round = 0; round < 3; ++round) {
    bring_up(joy);
    ASSERT_TRUE(joy.trigger(Transition::Deactivate).success);
    ASSERT_TRUE(joy.trigger(Transition::Cleanup).success);
  }
  EXPECT_EQ(context_.published<Joy>("/joy").size(), 3U) << "each deactivation stops";
  ASSERT_TRUE(joy.trigger(Transition::Shutdown).success);
}

std::string refusal_of(const std::map<std::string, ParameterValue>& overrides) {
  RecordingContext context;
  NodeOptions options{context};
  options.parameter_overrides(overrides);
  JoyComponent joy{options};
  const auto outcome = joy.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  return outcome.reason;
}

TEST(JoyParameters, what_is_wrong_is_named_with_the_way_out) {
  EXPECT_NE(refusal_of({{"dev", std::string{"/dev/input/no_pad"}}, {"required_device", true}})
                .find("/dev/input/no_pad: no such device"),
            std::string::npos);
  const std::string other = refusal_of({{"dev", std::string{"/dev/null"}}});
  EXPECT_NE(other.find("/dev/null: not an event device"), std::string::npos) << other;
  EXPECT_NE(refusal_of({{"device_name", std::string{"no pad is called so"}}, {"required_device", true}})
                .find("'no pad is called so'"),
            std::string::npos);
}

}  // namespace
}  // namespace nacelle::joy
