// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/emergency_latch.hpp"

#include <gtest/gtest.h>

namespace nacelle::diff_drive {
namespace {

constexpr MonotonicTime at(Duration since) { return {since}; }

TEST(EmergencyLatch, stays_set_until_it_is_released) {
  EmergencyLatch latch;
  EXPECT_FALSE(latch.is_set());
  EXPECT_TRUE(latch.take(true, at(1s)));
  EXPECT_TRUE(latch.take(true, at(2s)));
  EXPECT_FALSE(latch.take(false, at(3s)));
}

TEST(EmergencyLatch, an_older_release_does_not_undo_a_set) {
  EmergencyLatch latch;
  latch.take(true, at(5s));
  EXPECT_TRUE(latch.take(false, at(4s)));
  EXPECT_FALSE(latch.take(false, at(5s)));
}

TEST(EmergencyLatch, a_set_counts_however_old_it_is) {
  EmergencyLatch latch;
  latch.take(true, at(5s));
  latch.take(false, at(6s));
  EXPECT_TRUE(latch.take(true, at(1s))) << "a clock that is behind must not make a button dead";
  EXPECT_FALSE(latch.take(false, at(6s)));
}

}  // namespace
}  // namespace nacelle::diff_drive
