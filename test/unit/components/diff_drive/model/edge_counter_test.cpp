// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/edge_counter.hpp"

#include <gtest/gtest.h>

#include <array>

namespace nacelle::diff_drive {
namespace {

using Channel = EdgeCounter::Channel;

/// A disc with two sensors, a quarter of a period apart.
class Disc {
 public:
  explicit Disc(EdgeCounter& counter, bool has_b = true) : counter_(counter), has_b_(has_b) {}
  /// Turns by so many quarters of a period; positive: A leads B.
  void turn(int quarters) {
    for (; quarters != 0; quarters -= quarters > 0 ? 1 : -1) {
      const auto before = levels();
      position_ += quarters > 0 ? 1 : -1;
      ++now_ms_;
      if (levels()[0] != before[0]) edge(Channel::A, 0);
      if (levels()[1] != before[1] && has_b_) edge(Channel::B, 1);
    }
  }
  /// Edges that the kernel sees, and the counter does not.
  void turn_unseen(int quarters) {
    is_seen_ = false;
    turn(quarters);
    is_seen_ = true;
  }
  [[nodiscard]] MonotonicTime now() const { return MonotonicTime{now_ms_ * 1ms}; }

 private:
  [[nodiscard]] std::array<bool, 2> levels() const {
    const int phase = ((position_ % 4) + 4) % 4;  // 00 10 11 01
    return {phase == 1 || phase == 2, phase == 2 || phase == 3};
  }
  void edge(Channel channel, unsigned index) {
    ++numbers_.at(index);
    if (is_seen_) counter_.edge(channel, levels().at(index), numbers_.at(index), now());
  }

  EdgeCounter& counter_;
  const bool has_b_;
  int position_ = 0;
  bool is_seen_ = true;
  std::int64_t now_ms_ = 0;
  std::array<std::uint32_t, 2> numbers_{};
};

TEST(EdgeCounter, counts_four_edges_a_period_both_ways) {
  EdgeCounter counter{true};
  Disc disc{counter};
  disc.turn(41);
  EXPECT_EQ(counter.count(), 41);
  EXPECT_EQ(counter.edge_at(), disc.now());
  disc.turn(-100);
  EXPECT_EQ(counter.count(), -59);
  for (int i = 0; i < 50; ++i) {  // trembles on an edge
    disc.turn(1);
    disc.turn(-1);
  }
  EXPECT_EQ(counter.count(), -59);
  EXPECT_EQ(counter.edges(), 241U);
  EXPECT_EQ(counter.lost(), 0U);
}

TEST(EdgeCounter, begins_at_the_levels_that_it_finds) {
  EdgeCounter counter{true};
  Disc disc{counter};
  disc.turn_unseen(2);
  counter.begin(true, true);
  counter.edge(Channel::A, false, 1, {});
  counter.edge(Channel::B, false, 1, {});
  EXPECT_EQ(counter.count(), 2);
}

TEST(EdgeCounter, lost_edges_are_counted_in_the_last_direction) {
  for (const int direction : {1, -1}) {
    for (int unseen = 0; unseen < 40; ++unseen) {
      EdgeCounter counter{true};
      Disc disc{counter};
      disc.turn(10 * direction);
      disc.turn_unseen(unseen * direction);
      if (unseen != 0) counter.gap();
      disc.turn(10 * direction);
      EXPECT_EQ(counter.count(), direction * (20 + unseen)) << unseen;
      EXPECT_EQ(counter.lost(), static_cast<unsigned>(unseen));
      disc.turn(-7 * direction);
      EXPECT_EQ(counter.count(), direction * (13 + unseen)) << "and the direction is seen again";
    }
  }
}

TEST(EdgeCounter, numbers_wrap) {
  EdgeCounter counter{false};
  counter.edge(Channel::A, true, 0x70000000, {});
  counter.edge(Channel::A, false, 0xE0000000, {});
  counter.edge(Channel::A, true, 0xFFFFFFFE, {});
  const std::uint64_t lost = counter.lost();
  const std::int64_t count = counter.count();
  counter.edge(Channel::A, false, 0xFFFFFFFF, {});
  counter.edge(Channel::A, true, 0, {});
  counter.edge(Channel::A, false, 2, {});
  EXPECT_EQ(counter.lost() - lost, 1U);
  EXPECT_EQ(counter.count() - count, 4);
  counter.edge(Channel::A, true, 2, {});
  EXPECT_EQ(counter.lost() - lost, 1U) << "the same number again is no 4 billion edges";
}

TEST(EdgeCounter, one_channel_counts_in_the_direction_of_the_motor) {
  EdgeCounter counter{false};
  Disc disc{counter, false};
  counter.drive(1);
  disc.turn(20);
  EXPECT_EQ(counter.count(), 10);
  counter.drive(0);
  disc.turn(4);
  EXPECT_EQ(counter.count(), 12) << "it runs on";
  counter.drive(-1);
  disc.turn(-8);
  EXPECT_EQ(counter.count(), 8);
}

TEST(EdgeCounter, the_motor_does_not_matter_to_two_channels) {
  EdgeCounter counter{true};
  Disc disc{counter};
  counter.drive(-1);
  disc.turn(8);
  EXPECT_EQ(counter.count(), 8);
}

TEST(EdgeCounter, a_spike_without_its_second_edge_counts_nothing) {
  EdgeCounter counter{true};
  counter.begin(true, false);
  counter.edge(Channel::A, true, 1, MonotonicTime{1s});
  EXPECT_EQ(counter.count(), 0);
  EXPECT_FALSE(counter.edge_at());
}

}  // namespace
}  // namespace nacelle::diff_drive
