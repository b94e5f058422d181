// SPDX-License-Identifier: Apache-2.0
#include "imu/model/sample_assembler.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <random>

namespace nacelle::imu {
namespace {

constexpr Wt901Mask kAll = 0x021E;  // 51 52 53 54 59
constexpr Wt901Mask kRaw = 0x0006;  // 51 52

Wt901Frame frame(std::uint8_t type, std::int16_t value = 16384) { return {type, {value, 0, 0, 0}}; }

TEST(SampleAssembler, a_sample_is_complete_with_the_last_type_of_the_mask) {
  SampleAssembler assembler{kAll, 0.15e-6};
  EXPECT_FALSE(assembler.add(frame(0x51), {5ms}));
  EXPECT_FALSE(assembler.add(frame(0x52), {6ms}));
  EXPECT_FALSE(assembler.add(frame(0x53), {7ms}));
  EXPECT_FALSE(assembler.add(frame(0x54), {8ms}));
  EXPECT_TRUE(assembler.add(frame(0x59, 32767), {9ms}));
  EXPECT_EQ(assembler.sample().captured, MonotonicTime{5ms});
  ASSERT_TRUE(assembler.sample().orientation);
  EXPECT_NEAR(assembler.sample().orientation->w, 1.0, 1e-9) << "the quaternion is preferred to the angles";
  EXPECT_TRUE(assembler.sample().magnetic_field_t);
}

TEST(SampleAssembler, has_no_orientation_and_no_field_without_their_frames) {
  SampleAssembler assembler{kRaw, 0.15e-6};
  assembler.add(frame(0x51), {});
  ASSERT_TRUE(assembler.add(frame(0x52), {}));
  EXPECT_FALSE(assembler.sample().orientation);
  EXPECT_FALSE(assembler.sample().magnetic_field_t);
}

TEST(SampleAssembler, a_cycle_with_a_frame_missing_is_no_sample) {
  SampleAssembler assembler{kAll, 0.15e-6};
  for (const std::uint8_t type : {0x51, 0x53, 0x54}) EXPECT_FALSE(assembler.add(frame(type), {}));
  EXPECT_FALSE(assembler.add(frame(0x59, 32767), {}));
  EXPECT_EQ(assembler.stats().incomplete, 1U);
  EXPECT_EQ(assembler.stats().given_up_frames, 4U);
}

TEST(SampleAssembler, a_lost_last_frame_does_not_spoil_the_next_cycle) {
  SampleAssembler assembler{kRaw, 0.15e-6};
  assembler.add(frame(0x51, 1), {1ms});
  assembler.add(frame(0x51, 2), {11ms});
  ASSERT_TRUE(assembler.add(frame(0x52), {12ms}));
  EXPECT_EQ(assembler.sample().captured, MonotonicTime{11ms});
  EXPECT_NEAR(assembler.sample().acceleration_mps2[0], 2 * 16 * kGravityMps2 / 32768, 1e-12);
}

TEST(SampleAssembler, every_frame_is_accounted_for) {
  const unsigned seed = 17;
  std::mt19937 random{seed};
  SampleAssembler assembler{kAll, 0.15e-6};
  for (int i = 0; i < 10000; ++i) assembler.add(frame(static_cast<std::uint8_t>(0x50 + random() % 16)), {});
  assembler.restart();
  const auto& s = assembler.stats();
  EXPECT_EQ(s.frames, 5 * s.samples + s.given_up_frames) << "seed " << seed;
  EXPECT_EQ(s.frames + s.foreign_frames, 10000U);
}

}  // namespace
}  // namespace nacelle::imu
