// SPDX-License-Identifier: Apache-2.0
#include "proof/finding.hpp"

#include <gtest/gtest.h>

#include "nacelle/launch/launch_fault.hpp"

namespace nacelle::proof {
namespace {

const Finding kError{Severity::Error, {"a.yaml:3", "/a has no parameter 'b'", "did you mean 'c'?"}};
const Finding kWarning{Severity::Warning, {"", "odd", ""}};

TEST(Finding, is_a_line_with_its_weight_its_place_and_its_way_out) {
  EXPECT_EQ(kError.text(), "error: a.yaml:3: /a has no parameter 'b'; did you mean 'c'?");
  EXPECT_EQ(kWarning.text(), "warning: odd");
}

TEST(Finding, only_errors_make_a_plan_unsound) {
  EXPECT_FALSE(has_errors({}));
  EXPECT_FALSE(has_errors({kWarning}));
  EXPECT_TRUE(has_errors({kWarning, kError}));
}

TEST(Finding, the_summary_counts_both) {
  EXPECT_EQ(summary({}), "sound");
  EXPECT_EQ(summary({kWarning}), "1 warning");
  EXPECT_EQ(summary({kError, kWarning, kError}), "2 errors, 1 warning");
}

TEST(Finding, problems_of_a_launch_file_are_errors) {
  const auto findings = findings_of({{"a.yaml:1", "x", ""}, {"a.yaml:2", "y", "", launch::LaunchFault::Twice}});
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[1].problem.code, launch::LaunchFault::Twice);
  EXPECT_EQ(findings[1].about(), "launch_file");
  EXPECT_TRUE(has_errors(findings));
}

}  // namespace
}  // namespace nacelle::proof
