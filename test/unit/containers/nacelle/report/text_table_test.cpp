// SPDX-License-Identifier: Apache-2.0
#include "report/text_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace nacelle::report {
namespace {

TextTable streams() {
  TextTable table{
      {{"STREAM", false, 3}, {"HZ", true, 3}, {"PUBLISHED", true, 0}, {"READERS", true, 1}, {"DROPPED", false, 3}}};
  table.add_row({"/odometry/filtered", "50.00", "1234", "2", "-"});
  table.add_row({"/scan", "9.87", "39", "2", "14 overwritten, 3 pool_dry (1.2/s)"});
  table.add_line("  /monitor is late: its callback takes 48.0 ms");
  return table;
}

std::size_t widest_line_of(const std::string& text) {
  std::istringstream lines{text};
  std::size_t widest = 0;
  for (std::string line; std::getline(lines, line);) widest = std::max(widest, line.size());
  return widest;
}

TEST(TextTable, has_every_column_where_there_is_room) {
  EXPECT_EQ(streams().text(),
            "STREAM                HZ PUBLISHED READERS DROPPED\n"
            "/odometry/filtered 50.00      1234       2 -\n"
            "/scan               9.87        39       2 14 overwritten, 3 pool_dry (1.2/s)\n"
            "  /monitor is late: its callback takes 48.0 ms\n");
}

TEST(TextTable, leaves_the_least_important_columns_out_and_names_them) {
  EXPECT_EQ(streams().text(50),
            "(50 columns: without PUBLISHED)\n"
            "STREAM                HZ READERS DROPPED\n"
            "/odometry/filtered 50.00       2 -\n"
            "/scan               9.87       2\n"
            "  14 overwritten, 3 pool_dry (1.2/s)\n"
            "  /monitor is late: its callback takes 48.0 ms\n");
}

TEST(TextTable, is_no_wider_than_it_may_be) {
  for (const std::size_t width : {40U, 45U, 60U, 70U, 80U, 200U})
    EXPECT_LE(widest_line_of(streams().text(width)), width);
}

TEST(TextTable, keeps_what_matters_most_on_the_narrowest_terminal) {
  const std::string text = streams().text(5);
  for (const char* const title : {"STREAM", "HZ", "DROPPED"}) EXPECT_THAT(text, testing::HasSubstr(title));
}

TEST(TextTable, escapes_control_characters_of_cells_and_lines) {
  TextTable table{{{"STREAM", false, 1}, {"HZ", true, 1}}};
  table.add_row({"/a\x1b[2J\nb", "1"});
  table.add_line("  late: \r\xc2\x9b");
  EXPECT_EQ(table.text(),
            "STREAM         HZ\n"
            "/a\\x1b[2J\\x0ab  1\n"
            "  late: \\x0d\\xc2\\x9b\n");
}

}  // namespace
}  // namespace nacelle::report
