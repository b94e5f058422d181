// SPDX-License-Identifier: Apache-2.0
#include "cli/output.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

namespace nacelle::cli {
namespace {

TEST(Output, prints_text_from_outside_without_control_characters) {
  ::testing::internal::CaptureStdout();
  print_text("%s: %d\t%s\n", "a\x1b[2J\xc2\x9b", 7, std::string(5000, 'x').c_str());
  std::fflush(stdout);
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "a\\x1b[2J\\xc2\\x9b: 7\t" + std::string(5000, 'x') + "\n");
}

}  // namespace
}  // namespace nacelle::cli
