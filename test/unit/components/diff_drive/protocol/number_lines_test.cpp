// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/number_lines.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace nacelle::diff_drive {
namespace {

struct Lines {
  void feed(std::string_view text) {
    decoder.feed(
        as_bytes(text),
        [this](const NumberLine& line) {
          std::string shown(line.word);
          for (std::size_t i = 0; i < line.count; ++i) shown += "|" + std::to_string(line.numbers[i]);
          all.push_back(shown);
        },
        [this] { ++bad; });
    const auto& stats = decoder.stats();
    EXPECT_EQ(stats.bytes,
              stats.line_bytes + stats.malformed_bytes + stats.overlong_bytes + stats.blank_bytes + decoder.pending());
  }
  NumberLineDecoder decoder;
  std::vector<std::string> all;
  int bad = 0;
};
using Texts = std::vector<std::string>;

TEST(NumberLines, reads_words_numbers_comments_and_line_ends) {
  Lines lines;
  lines.feed("1.25 -0.5\r\nM 1 2\nE 10,-20\t3e1 ; three\n\r\n7\n");
  EXPECT_EQ(lines.all,
            (Texts{"|1.250000|-0.500000", "M|1.000000|2.000000", "E|10.000000|-20.000000|30.000000", "|7.000000"}));
  EXPECT_EQ(lines.bad, 0);
}

TEST(NumberLines, verifies_a_checksum_where_there_is_one) {
  // The XOR of "1.5 2" by hand: 31 ^ 2e ^ 35 ^ 20 ^ 32 (hex) = 38 = 56 decimal.
  Lines lines;
  lines.feed("1.5 2*56\r\n1.5 3*56\n1.5 2*5x\n1.5 2*\n");
  EXPECT_EQ(lines.all, Texts{"|1.500000|2.000000"});
  EXPECT_EQ(lines.bad, 3);
  EXPECT_EQ(lines.decoder.stats().bad_checksums, 1U);
}

TEST(NumberLines, refuses_what_is_no_finite_number) {
  Lines lines;
  lines.feed("invalid property\n1 nan\n1 inf\n1e999 1\n1 2 3 4 5 6 7\n-\n1 -\n" + std::string(200, '1') + "\n");
  EXPECT_EQ(lines.all, Texts{});
  EXPECT_EQ(lines.bad, 8);
  EXPECT_EQ(lines.decoder.stats().overlong_lines, 1U);
}

TEST(NumberLines, takes_any_chopping) {
  Lines whole, chopped;
  const std::string text = "E 1 2\nxyz!\n1.5 2*56\nQ\n";
  whole.feed(text);
  for (const char c : text) chopped.feed({&c, 1});
  EXPECT_EQ(whole.all, chopped.all);
  EXPECT_EQ(whole.decoder.stats(), chopped.decoder.stats());
}

TEST(NumberLinePrinter, prints_commands_with_checksums) {
  NumberLinePrinter printer;
  EXPECT_EQ(as_text(printer.text("v ").integer(0).text(" ").decimal(-1.25).end_checked().lines()), "v 0 -1.25*115\n");
  printer.clear();
  EXPECT_EQ(as_text(printer.decimal(0.0000004).text(" ").decimal(-0.5).text(" ").decimal(12.0).end().lines()),
            "0 -0.5 12\n");
}

}  // namespace
}  // namespace nacelle::diff_drive
