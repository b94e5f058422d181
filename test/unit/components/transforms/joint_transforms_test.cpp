// SPDX-License-Identifier: Apache-2.0
#include "transforms/model/joint_transforms.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/allocation_guard.hpp"

namespace nacelle::transforms {
namespace {

WallTime at_ms(std::int64_t ms) { return WallTime{Duration{ms * 1'000'000}}; }

RobotTree tree_of_wheels() {
  RobotTree tree;
  tree.joints = {
      {"right", "base", "right_link", JointKind::Turning, {}, Eigen::Vector3d::UnitZ(), {}},
      {"left", "base", "left_link", JointKind::Turning, {}, Eigen::Vector3d::UnitZ(), {}},
      {"mount", "base", "laser", JointKind::Fixed, {}, Eigen::Vector3d::UnitX(), {}},
      {"half", "base", "half_link", JointKind::Turning, {}, Eigen::Vector3d::UnitZ(), Mimic{"left", 0.5, 0.1}},
      {"quarter", "base", "quarter_link", JointKind::Turning, {}, Eigen::Vector3d::UnitZ(), Mimic{"half", -0.5, 1.0}}};
  return tree;
}

class JointTransformsTest : public ::testing::Test {
 protected:
  double yaw(std::span<const JointTransforms::Moved> moved, const char* name) {
    for (const auto& m : moved) {
      if (joints_.movable()[m.joint].name == name) return spatial::yaw_from_quaternion(m.X_parent_child.rotation);
    }
    return std::nan("");
  }
  std::span<const JointTransforms::Moved> update(std::int64_t ms, double left, double right) {
    const std::string names[] = {"left", "right"};
    const double positions[] = {left, right};
    return joints_.update(at_ms(ms), names, positions);
  }
  void expect_counts_add_up() {
    const auto& s = joints_.stats();
    EXPECT_EQ(s.messages, s.used + s.mismatched + s.too_soon + s.empty);
  }
  JointTransforms joints_{tree_of_wheels(), {}};
};

TEST_F(JointTransformsTest, joints_that_mimic_others_follow_through_their_chain) {
  const auto moved = update(1000, 0.8, -0.3);
  EXPECT_EQ(moved.size(), 4U);
  EXPECT_NEAR(yaw(moved, "left"), 0.8, 1e-12);
  EXPECT_NEAR(yaw(moved, "right"), -0.3, 1e-12);
  EXPECT_NEAR(yaw(moved, "half"), 0.5, 1e-12) << "0.5 * 0.8 + 0.1";
  EXPECT_NEAR(yaw(moved, "quarter"), 0.75, 1e-12) << "-0.5 * 0.5 + 1";
  expect_counts_add_up();
}

TEST_F(JointTransformsTest, the_mean_rate_is_the_limit_whatever_the_rate_of_the_joint_states) {
  for (const int period_ms : {5, 10, 20, 33}) {
    JointTransforms joints{tree_of_wheels(), {}};
    const std::string names[] = {"left", "right"};
    const double positions[] = {0.0, 0.0};
    int published = 0;
    for (int ms = 0; ms < 10000; ms += period_ms)
      published += joints.update(at_ms(100000 + ms), names, positions).empty() ? 0 : 1;
    EXPECT_NEAR(published, 300, 4) << "joint states every " << period_ms << " ms";
  }
}

TEST_F(JointTransformsTest, slow_joint_states_all_pass_and_a_silence_makes_no_burst) {
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(update(1000 + 100 * i, 0, 0).empty());
  EXPECT_FALSE(update(60000, 0, 0).empty());
  EXPECT_TRUE(update(60005, 0, 0).empty());
  EXPECT_TRUE(update(60010, 0, 0).empty());
  expect_counts_add_up();
}

TEST_F(JointTransformsTest, a_clock_that_was_set_back_publishes_again) {
  EXPECT_FALSE(update(5000, 0, 0).empty());
  EXPECT_FALSE(update(1000, 0, 0).empty());
  EXPECT_TRUE(update(1010, 0, 0).empty());
}

TEST_F(JointTransformsTest, what_is_not_usable_is_counted) {
  const std::string names[] = {"left", "gripper"};
  const double one[] = {1.0};
  const double two[] = {std::nan(""), 1.0};
  EXPECT_TRUE(joints_.update(at_ms(0), names, one).empty());
  EXPECT_TRUE(joints_.update(at_ms(0), names, two).empty());
  EXPECT_EQ(joints_.stats().mismatched, 1U);
  EXPECT_EQ(joints_.stats().unknown_joints, 1U);
  EXPECT_EQ(joints_.stats().not_finite, 1U);
  expect_counts_add_up();
}

TEST_F(JointTransformsTest, one_joint_many_times_in_a_message_is_one_transform) {
  const std::vector<std::string> names(1000, "left");
  const std::vector<double> positions(1000, 0.1);
  EXPECT_EQ(joints_.update(at_ms(1000), names, positions).size(), 3U) << "left and its two followers";
}

TEST(JointTransformsOptions, ignore_timestamp_takes_everything_and_zero_hertz_nothing) {
  const std::string names[] = {"left"};
  const double positions[] = {0.0};
  JointTransforms all{tree_of_wheels(), {30.0, true}};
  JointTransforms none{tree_of_wheels(), {0.0, false}};
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(all.update(at_ms(0), names, positions).empty());
    EXPECT_TRUE(none.update(at_ms(1000 * i), names, positions).empty());
  }
}

TEST_F(JointTransformsTest, allocates_nothing) {
  const std::string names[] = {"left", "right"};
  const double positions[] = {0.1, 0.2};
  std::size_t moved = 0;
  const test::AllocationGuard guard;
  for (int i = 0; i < 1000; ++i) moved += joints_.update(at_ms(20 * i), names, positions).size();
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(moved, 1000U);
}

}  // namespace
}  // namespace nacelle::transforms
