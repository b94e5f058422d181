// SPDX-License-Identifier: Apache-2.0
// Counters on a tree of plain files, edges on scripted lines.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diff_drive/port/counter_encoders.hpp"
#include "diff_drive/port/edge_encoders.hpp"
#include "nacelle/io/scripted_gpio.hpp"
#include "pwm_tree.hpp"

namespace nacelle::diff_drive {
namespace {

using ::testing::HasSubstr;

struct Counts {
  WheelCount left, right;
};
Counts read(WheelEncoders& encoders) {
  Counts counts;
  EXPECT_TRUE(encoders.read(counts.left, counts.right));
  return counts;
}

class CounterTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<WheelEncoders> open() const {
    return CounterEncoders::open(tree_.counter(0), tree_.counter(1)).value();
  }
  void count(const std::string& text) const { tree_.put("counter0/count0/count", text + "\n"); }
  PwmTree tree_;
};

TEST_F(CounterTest, counts_from_where_the_counter_is) {
  count("1000");
  const auto encoders = open();
  EXPECT_EQ(read(*encoders).left.count, 0);
  count("1100");
  tree_.put("counter0/count1/count", "7\n");
  EXPECT_EQ(read(*encoders).left.count, 100);
  EXPECT_EQ(read(*encoders).right.count, 7);
  EXPECT_FALSE(read(*encoders).left.edge_at);
}

TEST_F(CounterTest, goes_on_across_the_wrap_of_integers) {
  const auto encoders = open();
  count("18446744073709551566");  // -50 of 64 bits
  EXPECT_EQ(read(*encoders).left.count, -50);
  count("4294967196");  // -100 of 32 bits
  EXPECT_EQ(read(*encoders).left.count, -100);
  count("20");
  EXPECT_EQ(read(*encoders).left.count, 20);
}

TEST_F(CounterTest, goes_on_across_the_ceiling) {
  tree_.put("counter0/count0/ceiling", "999\n");
  const auto encoders = open();
  count("990");
  EXPECT_EQ(read(*encoders).left.count, -10);
  count("30");
  EXPECT_EQ(read(*encoders).left.count, 30);
  count("500");
  EXPECT_EQ(read(*encoders).left.count, 500);
  count("700");
  EXPECT_EQ(read(*encoders).left.count, 700);
  count("0");
  EXPECT_EQ(read(*encoders).left.count, 1000);
  tree_.put("counter0/count0/ceiling", "18446744073709551615\n");
  const auto wide = open();
  count("18446744073709551615");
  EXPECT_EQ(read(*wide).left.count, -1);
}

TEST_F(CounterTest, one_that_only_increases_counts_in_the_direction_of_the_motor) {
  tree_.put("counter0/count0/function", "increase\n");
  const auto encoders = open();
  encoders->drive(-1, 1);
  count("40");
  EXPECT_EQ(read(*encoders).left.count, -40);
  encoders->drive(0, 0);
  count("50");
  EXPECT_EQ(read(*encoders).left.count, -50);
  encoders->drive(1, -1);
  count("60");
  tree_.put("counter0/count1/count", "5\n");
  EXPECT_EQ(read(*encoders).left.count, -40);
  EXPECT_EQ(read(*encoders).right.count, 5) << "quadrature sees its direction itself";
}

TEST_F(CounterTest, is_switched_on_where_it_can_be) {
  tree_.put("counter0/count1/enable", "0\n");
  const auto encoders = open();
  EXPECT_EQ(tree_.get("counter0/count1/enable"), "1");
}

TEST_F(CounterTest, a_missing_one_is_named_with_the_other_way) {
  const auto missing = CounterEncoders::open(tree_.counter(0), tree_.counter(5));
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().text(), HasSubstr("count5"));
  EXPECT_THAT(missing.error().text(), HasSubstr("no such counter"));
  EXPECT_THAT(missing.error().text(), HasSubstr("pwm.encoder: gpio"));
  count("nothing");
  EXPECT_FALSE(CounterEncoders::open(tree_.counter(0), tree_.counter(1)));
}

TEST_F(CounterTest, one_that_was_away_goes_on_where_it_stopped) {
  const auto encoders = open();
  count("100");
  EXPECT_EQ(read(*encoders).left.count, 100);
  count("");
  Counts none;
  EXPECT_FALSE(encoders->read(none.left, none.right));
  EXPECT_FALSE(encoders->reopen());
  count("3");  // it counts from 0 again
  ASSERT_TRUE(encoders->reopen());
  count("13");
  EXPECT_EQ(read(*encoders).left.count, 110);
}

class EdgeTest : public ::testing::Test {
 protected:
  void make(bool has_b) {
    auto lines = std::make_unique<io::ScriptedInputs>();
    lines_ = lines.get();
    encoders_ = std::make_unique<EdgeEncoders>(std::move(lines), has_b);
  }
  /// Turns a wheel by whole periods of its encoder: four edges each.
  void turn(unsigned wheel, int periods) {
    for (int i = 0; i < std::abs(periods); ++i) {
      const unsigned a = 2 * wheel, b = a + 1;
      for (const unsigned line : periods > 0 ? std::array{a, b, a, b} : std::array{b, a, b, a}) {
        now_ += 1ms;
        lines_->set(line, (lines_->levels().value() >> line & 1U) == 0, now_);
      }
    }
  }
  MonotonicTime now_{5s};
  io::ScriptedInputs* lines_ = nullptr;
  std::unique_ptr<EdgeEncoders> encoders_;
};

TEST_F(EdgeTest, counts_both_wheels_with_the_times_of_their_edges) {
  make(true);
  turn(0, 10);
  const MonotonicTime left_at = now_;
  turn(1, -30);
  const Counts counts = read(*encoders_);
  EXPECT_EQ(counts.left.count, 40);
  EXPECT_EQ(counts.left.edge_at, left_at);
  EXPECT_EQ(counts.right.count, -120);
  EXPECT_EQ(counts.right.edge_at, now_);
  EXPECT_EQ(encoders_->stats().edges, 160U);
  EXPECT_EQ(encoders_->stats().lost, 0U);
}

TEST_F(EdgeTest, edges_that_the_kernel_dropped_are_counted_and_made_up_for) {
  make(true);
  for (std::size_t kept = 5; kept < 25; ++kept) {
    turn(0, 3);
    turn(1, 3);
    const Counts before = read(*encoders_);
    const auto lost_before = encoders_->stats().lost;
    lines_->kept = kept;
    turn(0, 20);  // 80 edges, of which as many are left as are kept
    EXPECT_EQ(read(*encoders_).left.count, before.left.count + 80) << kept;
    EXPECT_EQ(encoders_->stats().lost - lost_before, 80 - kept);
    turn(1, 2);
    EXPECT_EQ(read(*encoders_).right.count, before.right.count + 8) << "the other wheel lost none";
    lines_->kept = io::GpioInputs::kKept;
  }
}

TEST_F(EdgeTest, edges_that_overtook_each_other_are_put_in_order) {
  make(true);
  for (int period = 0; period < 10; ++period) {
    turn(0, 1);
    lines_->swap_last_two();
  }
  EXPECT_EQ(read(*encoders_).left.count, 40);
  EXPECT_EQ(encoders_->stats().lost, 0U);
}

/// Lines whose edges the test sets, with all their numbers.
class ToldInputs final : public io::GpioInputs {
 public:
  std::optional<std::uint64_t> levels() override { return 0; }
  std::optional<std::span<const io::GpioEdge>> take() override {
    return std::span<const io::GpioEdge>{edges.data(), std::exchange(count, 0)};
  }
  bool reopen() override { return true; }
  std::array<io::GpioEdge, kBatch> edges{};
  std::size_t count = 0;
};

// Seen on gpio-sim: an interrupt that comes before the kernel's thread has looked at the one before.
TEST(EdgeEncoders, edges_of_one_line_stay_in_order_when_their_numbers_in_the_request_are_equal) {
  auto inputs = std::make_unique<ToldInputs>();
  for (std::uint32_t i = 0; i < 40; ++i) inputs->edges.at(i) = {0, i % 2 == 0, {}, i + 1, 2 * (i / 2) + 2};
  inputs->count = 40;
  EdgeEncoders encoders{std::move(inputs), false};
  EXPECT_EQ(read(encoders).left.count, 40);
  EXPECT_EQ(encoders.stats().lost, 0U);
}

TEST_F(EdgeTest, two_edges_that_the_kernel_made_one_of_are_two) {
  make(true);
  turn(0, 2);
  // Each line rises and falls before the kernel looks at it: a period of which two events are left, with the levels as before.
  lines_->set(0, true, now_);
  lines_->set(0, false, now_);
  lines_->merge_last_two();
  lines_->set(1, true, now_);
  lines_->set(1, false, now_);
  lines_->merge_last_two();
  EXPECT_EQ(read(*encoders_).left.count, 12);
  EXPECT_EQ(encoders_->stats().lost, 2U);
  turn(0, 2);
  EXPECT_EQ(read(*encoders_).left.count, 20);
}

TEST_F(EdgeTest, one_channel_a_wheel_counts_in_the_direction_of_the_motor) {
  make(false);
  encoders_->drive(1, -1);
  for (int edge = 1; edge <= 9; ++edge) {
    now_ += 1ms;
    lines_->set(0, edge % 2 == 1, now_);
    lines_->set(1, edge % 2 == 1, now_);
  }
  EXPECT_EQ(read(*encoders_).left.count, 9);
  EXPECT_EQ(read(*encoders_).right.count, -9);
}

TEST_F(EdgeTest, lines_that_were_away_go_on_where_they_stopped) {
  make(true);
  turn(0, 5);
  EXPECT_EQ(read(*encoders_).left.count, 20);
  lines_->is_lost = true;
  Counts none;
  EXPECT_FALSE(encoders_->read(none.left, none.right));
  EXPECT_FALSE(encoders_->reopen());
  lines_->is_lost = false;
  turn(0, 100);
  ASSERT_TRUE(encoders_->reopen());
  turn(0, -1);
  EXPECT_EQ(read(*encoders_).left.count, 16);
  EXPECT_EQ(encoders_->stats().lost, 0U) << "numbers begin anew";
}

}  // namespace
}  // namespace nacelle::diff_drive
