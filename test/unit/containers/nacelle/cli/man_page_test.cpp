// SPDX-License-Identifier: Apache-2.0
#include "cli/man_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/live.hpp"

namespace nacelle::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(ManPage, holds_every_command_with_its_options) {
  Command root{"nacelle", "Nacelle: the whole robot in one process"};
  std::string topic;
  double rate = 1;
  bool flag = false;
  Command& echo = root.add("topic", "topics").add("echo", "show messages");
  echo.option("topic", topic, "its name").required();
  echo.option("-r,--rate", rate, "how often").within(0.5, 1e9).value("HZ");
  echo.flag("--secret", flag, "not for people").hidden();
  echo.runs([] { return 0; });
  echo.note(".first line\nsecond line");
  root.add("isolated", "x").hidden().runs([] { return 0; });

  const std::string page = man_page(root, "1.2.3");

  EXPECT_THAT(page, HasSubstr(".TH NACELLE 1 \"\" \"nacelle 1.2.3\""));
  EXPECT_THAT(page, HasSubstr("nacelle \\- the whole robot in one process"));
  EXPECT_THAT(page, HasSubstr(".SS nacelle topic echo\nshow messages.\n"));
  EXPECT_THAT(page, HasSubstr("[\\fIoptions\\fR]\n\\fItopic\\fR\n"));
  EXPECT_THAT(page, HasSubstr("\\fB\\-r\\fR, \\fB\\-\\-rate\\fR \\fIHZ\\fR\nhow often; 0.5 to 1000000000\n"));
  EXPECT_THAT(page, HasSubstr(".nf\n\\&.first line\nsecond line\n.fi"));
  EXPECT_THAT(page, Not(HasSubstr("secret")));
  EXPECT_THAT(page, Not(HasSubstr("isolated")));
}

TEST(Range, is_written_with_plain_numbers) {
  Option option;
  EXPECT_EQ(option.within(0, 1e15).range_text(), "0 to 1000000000000000");
  EXPECT_EQ(option.within(-1e6, 2.5).range_text(), "-1000000 to 2.5");
}

TEST(ManPage, takes_no_letter_for_a_request_of_roff) {
  EXPECT_EQ(roff(".br 'x' \\n a-b"), "\\&.br \\(aqx\\(aq \\en a\\-b");
  EXPECT_EQ(roff("'quoted"), "\\&\\(aqquoted");
  EXPECT_EQ(roff("one\n.two"), "one\n\\&.two");
}

TEST(LiveText, is_cut_to_the_terminal_and_clears_what_a_longer_line_left) {
  EXPECT_EQ(fit_to_terminal("one\ntwo\nthree\n", 3, 10), "one\033[K\ntwo\033[K\nthree\033[K\n");
  EXPECT_EQ(fit_to_terminal("one\ntwo\nthree\n", 2, 40), "one\033[K\n(2 more lines; --once shows all)\033[K\n");
  EXPECT_EQ(fit_to_terminal("abcdef\n", 5, 4), "abcd\033[K\n");
  EXPECT_EQ(fit_to_terminal("└─ ab\n", 5, 4), "└─ a\033[K\n") << "letters, not bytes";
}

}  // namespace
}  // namespace nacelle::cli
