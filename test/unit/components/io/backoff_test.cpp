// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/backoff.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

namespace nacelle::io {
namespace {

std::vector<Duration> next_pauses(Backoff& backoff, int count) {
  std::vector<Duration> pauses;
  for (int i = 0; i < count; ++i) pauses.push_back(backoff.next());
  return pauses;
}

TEST(Backoff, doubles_from_50_ms_up_to_a_second_by_default) {
  Backoff backoff;
  EXPECT_EQ(next_pauses(backoff, 8), (std::vector<Duration>{50ms, 100ms, 200ms, 400ms, 800ms, 1s, 1s, 1s}));
}

TEST(Backoff, begins_with_the_first_pause_again_after_a_success) {
  Backoff backoff{100ms};
  static_cast<void>(next_pauses(backoff, 30));

  backoff.reset();

  EXPECT_EQ(next_pauses(backoff, 6), (std::vector<Duration>{100ms, 200ms, 400ms, 800ms, 1s, 1s}));
}

TEST(Backoff, pauses_twice_as_long_each_time_and_never_longer_than_the_longest) {
  const unsigned seed = 20261126;
  std::mt19937 random{seed};
  for (int round = 0; round < 200; ++round) {
    const Duration first{std::uniform_int_distribution<std::int64_t>{1, 1'000'000'000}(random)};
    const Duration longest = first * std::uniform_int_distribution<std::int64_t>{1, 1000}(random);
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", first " << first.count() << " ns, longest "
                                      << longest.count() << " ns");
    Backoff backoff{first, longest};
    Duration before = backoff.next();
    ASSERT_EQ(before, first);
    for (int i = 0; i < 100; ++i) {
      const Duration pause = backoff.next();
      ASSERT_EQ(pause, std::min(2 * before, longest));
      before = pause;
    }
    ASSERT_EQ(before, longest);
    backoff.reset();
    ASSERT_EQ(backoff.next(), first);
  }
}

}  // namespace
}  // namespace nacelle::io
