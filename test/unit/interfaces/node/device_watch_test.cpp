// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/device_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/recording_host.hpp"

namespace nacelle {
namespace {

using ::testing::HasSubstr;

class Driver final : public LifecycleNode {
 public:
  explicit Driver(const NodeOptions& options) : LifecycleNode("driver", options) { declare_device_parameters(*this); }
};

class DeviceWatchTest : public ::testing::Test {
 protected:
  MonotonicTime at(Duration later) const { return began_ + later; }
  DeviceWatch watch(DeviceLost lost) {
    return DeviceWatch{driver_, {lost, false}, {"/dev/thing", 500ms, "THING_SILENT", 2s}, began_};
  }
  static std::string account() { return "7 bytes"; }

  test::RecordingContext context_;
  Driver driver_{NodeOptions{context_}};
  const MonotonicTime began_ = context_.clock().now();
};

TEST_F(DeviceWatchTest, silence_opens_a_fault_that_the_next_word_of_the_device_closes) {
  DeviceWatch watched = watch(DeviceLost::Wait);
  watched.look(at(500ms), account);
  EXPECT_TRUE(context_.open_faults().empty()) << "half a second is not too long";

  watched.look(at(501ms), account);
  ASSERT_EQ(context_.open_faults().size(), 1U);
  EXPECT_EQ(context_.open_faults()[0].code, kDeviceLost);
  EXPECT_THAT(context_.open_faults()[0].text, HasSubstr("/dev/thing: silent for 0.5 s (7 bytes)"));
  EXPECT_TRUE(watched.is_lost());

  watched.heard(at(1s));
  EXPECT_TRUE(context_.open_faults().empty());
  EXPECT_TRUE(context_.faults().empty()) << "nothing to apply on_fault to";
  watched.look(at(1501ms), account);
  EXPECT_EQ(context_.open_faults().size(), 1U) << "the silence counts from the last word";
}

TEST_F(DeviceWatchTest, reports_a_broken_line_at_once_with_the_latest_reason) {
  DeviceWatch watched = watch(DeviceLost::Wait);
  watched.lose("the line hung up");
  watched.lose("no right to open it");
  ASSERT_EQ(context_.open_faults().size(), 1U);
  EXPECT_EQ(context_.open_faults()[0].text, "/dev/thing: no right to open it");
}

TEST_F(DeviceWatchTest, the_old_behaviour_is_one_fault_after_the_drivers_own_limit) {
  DeviceWatch watched = watch(DeviceLost::Fault);
  watched.lose("the line hung up");
  watched.look(at(2s), account);
  EXPECT_TRUE(context_.faults().empty());
  watched.look(at(2001ms), account);
  watched.look(at(3s), account);
  ASSERT_EQ(context_.faults().size(), 1U);
  EXPECT_EQ(context_.faults()[0].code, "THING_SILENT");
  EXPECT_TRUE(context_.open_faults().empty());
}

TEST_F(DeviceWatchTest, its_end_closes_what_is_open) {
  {
    DeviceWatch watched = watch(DeviceLost::Wait);
    watched.lose("the line hung up");
    EXPECT_EQ(context_.open_faults().size(), 1U);
  }
  EXPECT_TRUE(context_.open_faults().empty());
}

TEST_F(DeviceWatchTest, a_slow_device_may_be_silent_for_three_of_its_periods) {
  EXPECT_EQ(silence_of(10ms), 400ms);
  EXPECT_EQ(silence_of(1s), 2900ms) << "a look each 100 ms reports it within 3 s";
  DeviceWatch watched = watch(DeviceLost::Wait);
  watched.expect_every(1s);
  watched.look(at(2900ms), account);
  EXPECT_TRUE(context_.open_faults().empty());
  watched.look(at(2901ms), account);
  EXPECT_EQ(context_.open_faults().size(), 1U);
}

TEST_F(DeviceWatchTest, the_parameters_are_read_and_a_wrong_word_is_named) {
  EXPECT_EQ(read_device_parameters(driver_)->lost, DeviceLost::Wait);
  EXPECT_FALSE(read_device_parameters(driver_)->required);
  driver_.set_parameter({"device_lost", std::string{"fault"}});
  EXPECT_EQ(read_device_parameters(driver_)->lost, DeviceLost::Fault);
  driver_.set_parameter({"device_lost", std::string{"fualt"}});
  ASSERT_FALSE(read_device_parameters(driver_));
  EXPECT_THAT(read_device_parameters(driver_).error().text(), HasSubstr("device_lost"));
}

}  // namespace
}  // namespace nacelle
