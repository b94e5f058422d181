// SPDX-License-Identifier: Apache-2.0
// The host's side of the protocols of home-made boards, against the reference firmware.
#include "diff_drive/component/home_made_board.hpp"

#include <gtest/gtest.h>

#include "../port/emulated_rig.hpp"

namespace nacelle::diff_drive {
namespace {

template <typename Rig>
class HomeMade : public ::testing::Test {
 protected:
  Rig rig_;
};
using Both = ::testing::Types<FramedRig, TextRig>;
TYPED_TEST_SUITE(HomeMade, Both);

TYPED_TEST(HomeMade, a_start_sets_the_boards_watchdog) {
  auto& rig = this->rig_;
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({3.0, 3.0}));
  rig.settle();
  rig.turn(1900ms);
  EXPECT_NEAR(rig.device().left_target_rps(), 3.0, 1e-3) << "2 s were set; without, it is 0.5 s";
  rig.turn(200ms);
  EXPECT_EQ(rig.device().left_target_rps(), 0.0);
}

TYPED_TEST(HomeMade, reports_battery_and_faults) {
  auto& rig = this->rig_;
  ASSERT_TRUE(rig.port().start());
  rig.run(40ms);
  EXPECT_NEAR(rig.run(40ms).voltage_v.value_or(0.0), 11.8, 1e-3);
  EXPECT_EQ(rig.fault, nullptr);
  rig.board().fault_bits = 0x04;
  rig.run(40ms);
  rig.run(40ms);
  EXPECT_STREQ(rig.fault, "motor board: the driver of the right motor");
  rig.board().fault_bits = 0;
  rig.run(40ms);
  rig.run(40ms);
  EXPECT_EQ(rig.fault, nullptr);
}

TYPED_TEST(HomeMade, skips_damaged_bytes) {
  auto& rig = this->rig_;
  ASSERT_TRUE(rig.port().start());
  rig.run(40ms);
  rig.on_answer = [n = 0](Bytes& bytes) mutable {
    if (n++ % 2 == 0) bytes.insert(bytes.begin() + 1, {0xFF, 'x', '\n'});
  };
  for (int i = 0; i < 5; ++i) rig.run(40ms);
  rig.on_answer = [](Bytes&) {};
  const auto heard = rig.states;
  rig.run(40ms);
  EXPECT_GT(rig.states, heard);
  EXPECT_GT(rig.port().stats().bytes_lost, 0U);
}

TEST(TextBoard, derives_the_rates_of_a_board_that_sends_counts_only) {
  class Ears final : public BoardEars {
   public:
    void on_wheels(const WheelReading& reading, std::uint64_t) override { last = reading; }
    void on_voltage(double) override {}
    void on_fault(const char*) override {}
    WheelReading last;
  } ears;
  TextBoard board{HomeMadeSettings{{{0, false}, {0, true}, 1000.0}}};
  board.feed(as_bytes("E 0 0\n"), MonotonicTime{10s}, ears);
  board.feed(as_bytes("E 100 -50\n"), MonotonicTime{10s + 50ms}, ears);
  EXPECT_NEAR(ears.last.rates.left_rps, 0.1 * 2.0 * std::numbers::pi / 0.05, 1e-9);
  EXPECT_NEAR(ears.last.rates.right_rps, 0.05 * 2.0 * std::numbers::pi / 0.05, 1e-9);
  EXPECT_NEAR(ears.last.right_rad, 0.05 * 2.0 * std::numbers::pi, 1e-9);
}

}  // namespace
}  // namespace nacelle::diff_drive
