// SPDX-License-Identifier: Apache-2.0
#include "session/early_crashes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace nacelle::session {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct EarlyCrashesTest : ::testing::Test {
  std::string folder = ::testing::TempDir() + "nacelle-early-XXXXXX";
  EarlyCrashesTest() { EXPECT_NE(::mkdtemp(folder.data()), nullptr); }
  ~EarlyCrashesTest() override { std::filesystem::remove_all(folder); }
  /// What a run knows after a start; `crash` is the record that lies there.
  EarlyCrashes start(bool resume, const std::optional<CrashFacts>& crash) const {
    EarlyCrashes crashes{folder + "/counts"};
    crashes.begin(resume, crash);
    return crashes;
  }
};

CrashFacts crash(int number, bool early, std::vector<std::string> nodes = {"/bad"}) {
  return {.id = std::to_string(number) + "/1", .nodes = std::move(nodes), .early = early, .text = "SIGSEGV in /bad"};
}

TEST_F(EarlyCrashesTest, a_component_is_left_out_after_two_crashes_in_a_row_that_came_early) {
  EXPECT_FALSE(start(true, crash(1, true)).is_left_out("/bad"));
  const EarlyCrashes second = start(true, crash(2, true));
  EXPECT_TRUE(second.is_left_out("/bad"));
  EXPECT_FALSE(second.is_left_out("/good"));
  EXPECT_EQ(second.reason("/bad"), "2 crashes within 30 s of its activation, the last: SIGSEGV in /bad");
  EXPECT_TRUE(start(true, crash(2, true)).is_left_out("/bad")) << "a run later, too";
}

TEST_F(EarlyCrashesTest, a_record_is_counted_once_and_one_of_an_earlier_run_not_at_all) {
  EXPECT_FALSE(start(false, crash(1, true)).last_run_crashed());
  EXPECT_FALSE(start(true, crash(1, true)).last_run_crashed()) << "that run was killed";
  EXPECT_TRUE(start(true, crash(2, true)).last_run_crashed());
  const EarlyCrashes again = start(true, crash(2, true));
  EXPECT_FALSE(again.last_run_crashed());
  EXPECT_FALSE(again.is_left_out("/bad"));
}

TEST_F(EarlyCrashesTest, a_late_crash_a_long_life_and_a_start_anew_forget_the_count) {
  static_cast<void>(start(true, crash(1, true)));
  static_cast<void>(start(true, crash(2, false)));
  EXPECT_FALSE(start(true, crash(3, true)).is_left_out("/bad")) << "a late one was between";

  start(true, crash(3, true)).forget("/bad");
  EXPECT_FALSE(start(true, crash(4, true)).is_left_out("/bad")) << "it ran for long";

  static_cast<void>(start(false, crash(4, true)));
  EXPECT_FALSE(start(true, crash(5, true)).is_left_out("/bad")) << "a start without --resume was between";
}

TEST_F(EarlyCrashesTest, a_file_that_is_damaged_counts_nothing) {
  for (const char* text : {"", "{", "[]", R"({"nacelle_crash_counts": 1})",
                           "{\"nacelle_crash_counts\": 1, \"counted\": 3, \"components\": []}",
                           R"({"nacelle_crash_counts": 1, "counted": "", "components": {"/bad": {"count": -1}}})"}) {
    std::ofstream{folder + "/counts"} << text;
    EXPECT_THAT(start(true, std::nullopt).nodes(), ::testing::IsEmpty()) << text;
  }
}

TEST(CrashFacts, are_the_components_the_age_and_a_line_for_a_person) {
  const auto facts = crash_facts(
      "nacelle crash record\nsignal: SIGSEGV at address 0x0\ntime: 7 s after 1970\nprocess: 42\ncomponent: /a or /b/c\n"
      "callback: thread rx\ncomponent age: 29999 ms since its activation\nlibrary: /lib/x.so +0x1\n"
      "symbol: _ZN5lidar6Driver4readEv\n");
  ASSERT_TRUE(facts);
  EXPECT_THAT(facts->nodes, ElementsAre("/a", "/b/c"));
  EXPECT_TRUE(facts->early);
  EXPECT_EQ(facts->text, "SIGSEGV at address 0x0 in /a or /b/c, thread rx, at lidar::Driver::read()");
  EXPECT_THAT(facts->id, HasSubstr("42"));
  EXPECT_FALSE(crash_facts("signal: SIGSEGV\ncomponent: /a\ncomponent age: 30001 ms since its activation\n")->early);
  EXPECT_FALSE(crash_facts("signal: SIGSEGV\ncomponent: /a\n")->early) << "the age is not known";
  EXPECT_FALSE(crash_facts("no record"));
}

}  // namespace
}  // namespace nacelle::session
