// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/fault_topics.hpp"

#include <gtest/gtest.h>

namespace nacelle::session {
namespace {

// Numbers and labels of rcl_lifecycle's default_state_machine.c.
TEST(TransitionNames, are_those_of_lifecycle_msgs) {
  using S = StateId;
  const struct {
    S from, to;
    int id;
    const char* label;
  } steps[] = {
      {S::Unconfigured, S::Configuring, 1, "configure"},
      {S::Configuring, S::Inactive, 10, "transition_success"},
      {S::Configuring, S::Unconfigured, 11, "transition_failure"},
      {S::Configuring, S::ErrorProcessing, 12, "transition_error"},
      {S::Inactive, S::CleaningUp, 2, "cleanup"},
      {S::CleaningUp, S::Unconfigured, 20, "transition_success"},
      {S::Inactive, S::Activating, 3, "activate"},
      {S::Activating, S::Active, 30, "transition_success"},
      {S::Activating, S::Inactive, 31, "transition_failure"},
      {S::Active, S::Deactivating, 4, "deactivate"},
      {S::Deactivating, S::Inactive, 40, "transition_success"},
      {S::Deactivating, S::ErrorProcessing, 42, "transition_error"},
      {S::Unconfigured, S::ShuttingDown, 5, "shutdown"},
      {S::Inactive, S::ShuttingDown, 6, "shutdown"},
      {S::Active, S::ShuttingDown, 7, "shutdown"},
      {S::ShuttingDown, S::Finalized, 50, "transition_success"},
      {S::ErrorProcessing, S::Unconfigured, 60, "transition_success"},
      {S::ErrorProcessing, S::Finalized, 61, "transition_failure"},
      {S::Active, S::ErrorProcessing, 99, "transition_error"},
  };
  for (const auto& step : steps) {
    const TransitionName name = name_of_step(step.from, step.to);
    EXPECT_EQ(name.id, step.id) << to_text(step.from) << " -> " << to_text(step.to);
    EXPECT_STREQ(name.label, step.label) << to_text(step.from) << " -> " << to_text(step.to);
  }
}

}  // namespace
}  // namespace nacelle::session
