// SPDX-License-Identifier: Apache-2.0
#include "drive/model/thinned_log.hpp"

#include <gmock/gmock.h>

namespace nacelle::drive {
namespace {

std::vector<int> after(int count, std::size_t most) {
  ThinnedLog<int> log{most};
  for (int i = 0; i < count; ++i) log.add(i);
  return log.samples();
}

TEST(ThinnedLog, keeps_all_samples_of_a_short_run) {
  EXPECT_THAT(after(0, 4), testing::IsEmpty());
  EXPECT_THAT(after(4, 4), testing::ElementsAre(0, 1, 2, 3));
}

TEST(ThinnedLog, forgets_every_second_one_when_it_is_full) {
  EXPECT_THAT(after(5, 4), testing::ElementsAre(0, 2, 4));
  EXPECT_THAT(after(6, 4), testing::ElementsAre(0, 2, 4, 5)) << "the newest is always there";
  EXPECT_THAT(after(9, 4), testing::ElementsAre(0, 4, 8));
}

TEST(ThinnedLog, stays_bounded_even_and_complete_over_a_long_run) {
  for (const int count : {100, 1'000, 65'537}) {
    const auto kept = after(count, 64);
    EXPECT_LE(kept.size(), 65U);
    EXPECT_GE(kept.size(), 32U);
    EXPECT_EQ(kept.front(), 0);
    EXPECT_EQ(kept.back(), count - 1);
    for (std::size_t i = 2; i + 1 < kept.size(); ++i) EXPECT_EQ(kept[i] - kept[i - 1], kept[1]) << "of " << count;
  }
}

}  // namespace
}  // namespace nacelle::drive
