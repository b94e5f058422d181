// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/can_frame.hpp"

#include <gtest/gtest.h>
#include <linux/can.h>

#include <cstring>
#include <random>
#include <vector>

namespace nacelle::diff_drive {
namespace {

CanRecord kernels_own(const can_frame& frame) {
  CanRecord record{};
  static_assert(sizeof frame == sizeof record);
  std::memcpy(record.data(), &frame, sizeof frame);
  return record;
}

TEST(CanRecord, is_the_kernels_own_structure) {
  can_frame kernels{};
  kernels.can_id = 0x1B04 | CAN_EFF_FLAG;
  kernels.can_dlc = 3;
  kernels.data[0] = 1;
  kernels.data[2] = 3;
  const CanFrame ours{0x1B04, true, false, 3, {1, 0, 3}};
  EXPECT_EQ(to_record(ours), kernels_own(kernels));
  EXPECT_EQ(from_record(kernels_own(kernels)), ours);

  kernels = {};
  kernels.can_id = 0x29 | CAN_RTR_FLAG;
  kernels.can_dlc = 8;
  const CanFrame request{0x29, false, true, 8, {}};
  EXPECT_EQ(to_record(request), kernels_own(kernels));
  EXPECT_EQ(from_record(kernels_own(kernels)), request);
}

TEST(CanRecord, what_no_controller_sends_is_no_frame) {
  can_frame kernels{};
  kernels.can_id = CAN_ERR_FLAG | 0x40;
  kernels.can_dlc = 8;
  EXPECT_EQ(from_record(kernels_own(kernels)), std::nullopt) << "an error of the controller";
  kernels.can_id = 0x29;
  kernels.can_dlc = 9;
  EXPECT_EQ(from_record(kernels_own(kernels)), std::nullopt) << "nine bytes";
  kernels.can_id = 0x800;
  kernels.can_dlc = 1;
  EXPECT_EQ(from_record(kernels_own(kernels)), std::nullopt) << "twelve bits in eleven";
}

TEST(CanRecord, survives_the_way_there_and_back) {
  std::mt19937 random{20261128};
  for (int i = 0; i < 1000; ++i) {
    CanFrame frame;
    frame.is_extended = random() % 2 == 0;
    frame.is_request = random() % 4 == 0;
    frame.id = random() & (frame.is_extended ? 0x1FFFFFFFU : 0x7FFU);
    frame.length = static_cast<std::uint8_t>(random() % 9);
    if (!frame.is_request) {
      for (std::size_t at = 0; at < frame.length; ++at) frame.data[at] = static_cast<std::uint8_t>(random());
    }
    ASSERT_EQ(from_record(to_record(frame)), frame) << "frame " << i << " of seed 20261128";
  }
}

std::optional<std::uint32_t> even_id(const CanFrame& frame) {
  return frame.id % 2 == 0 ? std::optional{frame.id} : std::nullopt;
}

TEST(CanDecoder, accounts_for_every_byte_in_any_chopping) {
  std::mt19937 random{7};
  CanDecoder<&even_id> whole, chopped;
  std::vector<std::uint32_t> at_once, in_parts;
  Bytes bytes(16 * 500 + 5);
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::uint8_t>(i % 16 == 4 ? random() % 10 : random());
  whole.feed(bytes, [&](std::uint32_t id, std::uint64_t first_byte) {
    EXPECT_EQ(first_byte % 16, 0U);
    at_once.push_back(id);
  });
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t part = std::min<std::size_t>(bytes.size() - at, 1 + random() % 40);
    chopped.feed(ByteView{bytes}.subspan(at, part), [&](std::uint32_t id, std::uint64_t) { in_parts.push_back(id); });
    at += part;
    const auto& stats = chopped.stats();
    ASSERT_EQ(stats.bytes, stats.report_bytes + stats.other_bytes + stats.lost_bytes + chopped.pending());
  }
  EXPECT_FALSE(at_once.empty());
  EXPECT_EQ(at_once, in_parts);
  EXPECT_EQ(whole.stats(), chopped.stats());
  EXPECT_GT(whole.stats().other_bytes, 0U);
  EXPECT_GT(whole.stats().lost_bytes, 0U);
  EXPECT_EQ(whole.pending(), 5U);
  whole.restart();
  EXPECT_EQ(whole.pending(), 0U);
  EXPECT_EQ(whole.stats().bytes, whole.stats().report_bytes + whole.stats().other_bytes + whole.stats().lost_bytes);
}

}  // namespace
}  // namespace nacelle::diff_drive
