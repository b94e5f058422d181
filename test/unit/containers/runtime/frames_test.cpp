// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/frames.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace nacelle::runtime {
namespace {

ClaimedFrame frame(const std::string& node, const std::string& parent, const std::string& child,
                   FrameClaimKind kind = FrameClaimKind::Primary) {
  ClaimedFrame made;
  made.node = node;
  made.parent = parent;
  made.child = child;
  made.kind = kind;
  return made;
}

TEST(FrameRegistry, gives_a_frame_to_the_first_claim_that_is_no_fallback) {
  FrameRegistry frames;
  const auto fallback = frames.claim(frame("/odometry", "odom", "base", FrameClaimKind::Fallback));
  EXPECT_TRUE(fallback->is_owner());

  auto filter = frames.claim(frame("/ekf", "odom", "base"));
  const auto late = frames.claim(frame("/other", "odom", "base"));

  EXPECT_TRUE(filter->is_owner());
  EXPECT_FALSE(late->is_owner());
  EXPECT_FALSE(fallback->is_owner());
  EXPECT_EQ(fallback->owner(), "/ekf");
  EXPECT_EQ(filter->owner(), "");
  filter.reset();
  EXPECT_TRUE(late->is_owner());
}

TEST(FrameRegistry, withdraws_all_frames_of_a_node_and_no_others) {
  FrameRegistry frames;
  const auto first = frames.claim(frame("/a", "base", "laser"));
  const auto second = frames.claim(frame("/b", "base", "laser"));
  const auto camera = frames.claim(frame("/a", "base", "camera"));

  frames.withdraw("/a");

  EXPECT_FALSE(first->is_owner());
  EXPECT_FALSE(camera->is_owner());
  EXPECT_TRUE(second->is_owner());
  ASSERT_EQ(frames.list().size(), 1U);
  EXPECT_EQ(frames.list().front().node, "/b");
}

TEST(FrameRegistry, lists_frames_in_the_order_of_their_claims) {
  FrameRegistry frames;
  std::vector<std::unique_ptr<FrameClaim>> claims;
  for (int i = 0; i < 100; ++i) claims.push_back(frames.claim(frame("/a", "base", "f" + std::to_string(i % 50))));

  const auto all = frames.list();

  ASSERT_EQ(all.size(), 100U);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].child, "f" + std::to_string(i % 50));
    EXPECT_EQ(all[i].owns, i < 50);
  }
  EXPECT_EQ(frames.conflicts().size(), 50U) << "each pair once";
}

// Comparing each with each would take 10^10 steps.
TEST(FrameRegistry, takes_a_hundred_thousand_frames) {
  FrameRegistry frames;
  std::vector<std::unique_ptr<FrameClaim>> claims;
  for (int i = 0; i < 100'000; ++i)
    claims.push_back(frames.claim(frame("/a", "l" + std::to_string(i), "l" + std::to_string(i + 1))));

  EXPECT_TRUE(frames.conflicts().empty());
  EXPECT_TRUE(claims.back()->is_owner());
  claims.clear();
  EXPECT_TRUE(frames.list().empty());
}

}  // namespace
}  // namespace nacelle::runtime
