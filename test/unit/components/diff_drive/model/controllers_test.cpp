// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/controllers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nacelle::diff_drive {
namespace {

using State = ControllerState;
using ::testing::HasSubstr;

const std::string kDrive = kControllers[kDiffDriveController].name;
const std::string kJoints = kControllers[kJointStateBroadcaster].name;

SwitchOrder strict(std::vector<std::string> activate, std::vector<std::string> deactivate) {
  return {std::move(activate), std::move(deactivate), true};
}
SwitchOrder best_effort(std::vector<std::string> activate, std::vector<std::string> deactivate) {
  return {std::move(activate), std::move(deactivate), false};
}

TEST(Controllers, follow_the_base_until_an_order_says_otherwise) {
  Controllers controllers;
  for (const State base : {State::Unconfigured, State::Inactive, State::Active}) {
    EXPECT_EQ(controllers.state(kDiffDriveController, base), base);
    EXPECT_EQ(controllers.state(kJointStateBroadcaster, base), base);
  }
  controllers.set(kDiffDriveController, State::Inactive);
  EXPECT_EQ(controllers.state(kDiffDriveController, State::Active), State::Inactive);
  EXPECT_EQ(controllers.state(kDiffDriveController, State::Unconfigured), State::Unconfigured);
  EXPECT_EQ(controllers.state(kDiffDriveController, State::Active), State::Inactive) << "also after the base was away";
  EXPECT_EQ(controllers.state(kJointStateBroadcaster, State::Active), State::Active);
}

TEST(Controllers, a_strict_order_with_an_unknown_name_is_refused_by_that_name) {
  const Controllers controllers;
  for (const SwitchOrder& order : {strict({}, {kDrive, "arm_controller"}), strict({"arm_controller"}, {kDrive})}) {
    const auto plan = controllers.plan(order, State::Active);
    ASSERT_FALSE(plan);
    EXPECT_THAT(plan.error(), HasSubstr("arm_controller"));
    EXPECT_THAT(plan.error(), HasSubstr(kJoints)) << "it says which there are";
  }
}

TEST(Controllers, a_best_effort_order_does_what_it_can) {
  const Controllers controllers;
  const auto plan = controllers.plan(best_effort({kJoints}, {"arm_controller", kDrive}), State::Active);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->deactivates, (ControllerSet{true, false}));
  EXPECT_EQ(plan->activates, ControllerSet{}) << "it is active already";
  ASSERT_EQ(plan->left_out.size(), 2U);
  EXPECT_THAT(plan->left_out[0], HasSubstr("arm_controller"));
  EXPECT_THAT(plan->left_out[1], HasSubstr("already active"));
}

TEST(Controllers, a_best_effort_order_of_unknown_names_only_is_refused) {
  const auto plan = Controllers{}.plan(best_effort({kJoints}, {"arm_controller"}), State::Active);
  ASSERT_FALSE(plan);
  EXPECT_THAT(plan.error(), HasSubstr("arm_controller"));
}

TEST(Controllers, an_order_for_the_state_that_is_there_is_an_error_only_if_it_is_strict) {
  Controllers controllers;
  EXPECT_FALSE(controllers.plan(strict({kDrive}, {}), State::Active));
  const auto again = controllers.plan(best_effort({kDrive}, {}), State::Active);
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->is_empty());

  controllers.set(kDiffDriveController, State::Inactive);
  EXPECT_FALSE(controllers.plan(strict({}, {kDrive}), State::Active));
  EXPECT_TRUE(controllers.plan(strict({kDrive}, {}), State::Active));
}

TEST(Controllers, one_in_both_lists_is_restarted_if_it_is_active) {
  Controllers controllers;
  const auto restart = controllers.plan(strict({kDrive}, {kDrive}), State::Active);
  ASSERT_TRUE(restart);
  EXPECT_EQ(restart->activates, (ControllerSet{true, false}));
  EXPECT_EQ(restart->deactivates, (ControllerSet{true, false}));

  controllers.set(kDiffDriveController, State::Inactive);
  EXPECT_FALSE(controllers.plan(strict({kDrive}, {kDrive}), State::Active));
  const auto start = controllers.plan(best_effort({kDrive}, {kDrive}), State::Active);
  ASSERT_TRUE(start);
  EXPECT_EQ(start->activates, (ControllerSet{true, false}));
  EXPECT_EQ(start->deactivates, ControllerSet{});
}

TEST(Controllers, nothing_is_activated_while_the_base_is_not_active) {
  for (const bool is_strict : {true, false}) {
    const auto plan = Controllers{}.plan({{kDrive}, {}, is_strict}, State::Inactive);
    ASSERT_FALSE(plan);
    EXPECT_THAT(plan.error(), HasSubstr("the base is inactive"));
  }
  const auto early = Controllers{}.plan(strict({kDrive}, {}), State::Unconfigured);
  ASSERT_FALSE(early);
  EXPECT_THAT(early.error(), HasSubstr("configure the base first"));
}

TEST(Controllers, an_empty_order_is_nothing_to_do) {
  const auto plan = Controllers{}.plan(strict({}, {}), State::Active);
  ASSERT_TRUE(plan);
  EXPECT_TRUE(plan->is_empty());
}

TEST(Controllers, an_active_one_is_deactivated_cleaned_up_unloaded_and_comes_back) {
  Controllers controllers;
  EXPECT_FALSE(controllers.cleanup(kDrive, State::Active));
  EXPECT_FALSE(controllers.unload(kDrive, State::Active));
  EXPECT_FALSE(controllers.configure(kDrive, State::Active));
  EXPECT_FALSE(controllers.load(kDrive));
  EXPECT_EQ(controllers.state(kDiffDriveController, State::Active), State::Active);

  controllers.set(kDiffDriveController, State::Inactive);
  EXPECT_TRUE(controllers.configure(kDrive, State::Active)) << "it is";
  EXPECT_EQ(controllers.state(kDiffDriveController, State::Active), State::Inactive);
  ASSERT_TRUE(controllers.cleanup(kDrive, State::Active));
  EXPECT_TRUE(controllers.cleanup(kDrive, State::Active)) << "it is";
  EXPECT_EQ(controllers.state(kDiffDriveController, State::Active), State::Unconfigured);
  EXPECT_FALSE(controllers.plan(strict({kDrive}, {}), State::Active));
  ASSERT_TRUE(controllers.unload(kDrive, State::Active));
  EXPECT_EQ(controllers.state(kDiffDriveController, State::Active), State::Unloaded);
  EXPECT_FALSE(controllers.plan(strict({kDrive}, {}), State::Active));
  EXPECT_FALSE(controllers.configure(kDrive, State::Active));

  ASSERT_TRUE(controllers.load(kDrive));
  EXPECT_EQ(controllers.state(kDiffDriveController, State::Active), State::Unconfigured);
  ASSERT_TRUE(controllers.configure(kDrive, State::Active));
  EXPECT_EQ(controllers.state(kDiffDriveController, State::Active), State::Inactive);
  EXPECT_TRUE(controllers.plan(strict({kDrive}, {}), State::Active));
}

TEST(Controllers, other_names_and_an_unconfigured_base_are_reasons) {
  Controllers controllers;
  EXPECT_THAT(controllers.load("arm_controller").error(), HasSubstr("arm_controller"));
  EXPECT_THAT(controllers.unload("arm_controller", State::Inactive).error(), HasSubstr("arm_controller"));
  EXPECT_THAT(controllers.configure("arm_controller", State::Inactive).error(), HasSubstr("arm_controller"));
  EXPECT_THAT(controllers.cleanup("arm_controller", State::Inactive).error(), HasSubstr("arm_controller"));
  EXPECT_THAT(controllers.configure(kDrive, State::Unconfigured).error(), HasSubstr("the base is unconfigured"));
}

}  // namespace
}  // namespace nacelle::diff_drive
