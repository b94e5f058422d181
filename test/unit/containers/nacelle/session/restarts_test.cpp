// SPDX-License-Identifier: Apache-2.0
#include "session/restarts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nacelle::session {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr MonotonicTime kStart{100s};
const FaultHandling kTwice{FaultPolicy::Restart, 2, 500ms};

TEST(Restarts, a_restart_is_due_after_the_pause_and_once) {
  Restarts restarts;

  EXPECT_EQ(restarts.on_fault("/a", kTwice, kStart), kStart + 500ms);

  EXPECT_EQ(restarts.next_due(), kStart + 500ms);
  EXPECT_THAT(restarts.take_due(kStart + 499ms), IsEmpty());
  EXPECT_THAT(restarts.take_due(kStart + 500ms), ElementsAre("/a"));
  EXPECT_THAT(restarts.take_due(kStart + 500ms), IsEmpty());
  EXPECT_EQ(restarts.next_due(), std::nullopt);
}

TEST(Restarts, there_are_no_more_than_so_many_in_a_row) {
  Restarts restarts;
  MonotonicTime now = kStart;
  for (std::uint32_t i = 1; i <= 2; ++i) {
    ASSERT_TRUE(restarts.on_fault("/a", kTwice, now));
    EXPECT_EQ(restarts.count_of("/a"), i);
    now += 1s;
    ASSERT_THAT(restarts.take_due(now), ElementsAre("/a"));
  }

  EXPECT_EQ(restarts.on_fault("/a", kTwice, now), std::nullopt);
  EXPECT_TRUE(restarts.on_fault("/b", kTwice, now)) << "each component has its own count";
}

TEST(Restarts, who_was_well_for_a_minute_begins_anew) {
  Restarts restarts;
  ASSERT_TRUE(restarts.on_fault("/a", kTwice, kStart));
  static_cast<void>(restarts.take_due(kStart + 1s));

  ASSERT_TRUE(restarts.on_fault("/a", kTwice, kStart + 1s + Restarts::kWell + 1ns));

  EXPECT_EQ(restarts.count_of("/a"), 1U);
}

TEST(Restarts, a_second_fault_before_the_restart_changes_nothing) {
  Restarts restarts;
  ASSERT_TRUE(restarts.on_fault("/a", kTwice, kStart));

  EXPECT_EQ(restarts.on_fault("/a", kTwice, kStart + 100ms), kStart + 500ms);

  EXPECT_EQ(restarts.count_of("/a"), 1U);
}

TEST(FaultHandling, what_moves_something_stops_the_robot_by_default) {
  EXPECT_EQ(FaultHandling{}.policy_for(true), FaultPolicy::StopRobot);
  EXPECT_EQ(FaultHandling{}.policy_for(false), FaultPolicy::Degrade);
  EXPECT_EQ(kTwice.policy_for(true), FaultPolicy::Restart);
}

}  // namespace
}  // namespace nacelle::session
