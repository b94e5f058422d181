// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/latest_value.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace nacelle::diff_drive {
namespace {

struct Pair {
  std::uint64_t a = 0, b = 0, c = 0, d = 0;
};

TEST(LatestValue, is_empty_until_something_was_put) {
  LatestValue<int> value;
  EXPECT_FALSE(value.take());
}

TEST(LatestValue, gives_the_newest_once) {
  LatestValue<int> value;
  value.put(1);
  value.put(2);
  EXPECT_EQ(value.take(), 2);
  EXPECT_FALSE(value.take());
  value.put(3);
  EXPECT_EQ(value.take(), 3);
}

TEST(LatestValue, never_shows_half_a_value_nor_an_older_one_after_a_newer) {
  LatestValue<Pair> value;
  constexpr std::uint64_t kLast = 200'000;
  std::thread writer{[&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) value.put({i, i, i, i});
  }};
  std::uint64_t seen = 0;
  bool whole = true, ordered = true;
  while (seen != kLast) {
    const auto taken = value.take();
    if (!taken) continue;
    whole = whole && taken->a == taken->b && taken->b == taken->c && taken->c == taken->d;
    ordered = ordered && taken->a > seen;
    seen = taken->a;
  }
  writer.join();
  EXPECT_TRUE(whole);
  EXPECT_TRUE(ordered);
}

}  // namespace
}  // namespace nacelle::diff_drive
