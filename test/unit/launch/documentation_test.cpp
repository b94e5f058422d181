// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "in_memory.hpp"
#include "support/places.hpp"

namespace nacelle::launch {
namespace {

/// The YAML blocks of docs/launch_files.md by the file name in their first line.
std::map<std::string, std::string> examples() {
  std::ifstream file{test::source("docs/launch_files.md")};
  const std::string page{std::istreambuf_iterator<char>{file}, {}};
  constexpr std::string_view kBegin = "\n```yaml\n# ", kEnd = "\n```\n";
  std::map<std::string, std::string> all;
  for (std::size_t at = 0; (at = page.find(kBegin, at)) != std::string::npos;) {
    at += kBegin.size();
    const std::size_t line = page.find('\n', at), end = page.find(kEnd, line);
    all["/docs/" + page.substr(at, line - at)] = page.substr(line + 1, end - line);
    at = end;
  }
  // None escapes by another first line.
  const auto blocks = [&] {
    std::size_t count = 0;
    for (std::size_t at = 0; (at = page.find("```yaml", at)) != std::string::npos; ++at) ++count;
    return count;
  }();
  EXPECT_EQ(all.size(), blocks);
  return all;
}

TEST(LaunchFilesPage, shows_files_that_load) {
  const auto files = examples();
  EXPECT_GE(files.size(), 6U);
  for (const auto& [name, text] : files) {
    if (name.ends_with("/robot.yaml")) {
      EXPECT_TRUE(parse_parameter_file(text, name)) << name;
      continue;
    }
    if (name.ends_with("/refused.launch.yaml")) continue;
    const auto plan = load_plan(name, {}, in_memory(files));
    ASSERT_TRUE(plan) << problems_of(plan);
    EXPECT_TRUE(plan->container.declared || !plan->programs.empty()) << name;
  }
}

TEST(LaunchFilesPage, shows_the_keys_that_are_refused_today) {
  const std::string told = problems_of(load_plan("/docs/refused.launch.yaml", {}, in_memory(examples())));
  EXPECT_EQ(std::count(told.begin(), told.end(), '\n'), 1) << told;
  EXPECT_NE(told.find("respawn"), std::string::npos) << told;
  std::size_t unavailable = 0;
  for (std::size_t at = 0; (at = told.find("not available yet", at)) != std::string::npos; ++at) ++unavailable;
  EXPECT_EQ(unavailable, 1U) << told;
}

}  // namespace
}  // namespace nacelle::launch
