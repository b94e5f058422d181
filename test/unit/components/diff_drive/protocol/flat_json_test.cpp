// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/flat_json.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace nacelle::diff_drive {
namespace {

struct Read {
  std::vector<std::string> members;  // "key=1.5", "key=-" for a value that is no number
  bool failed = false;
};
Read read(std::string_view line) {
  Read result;
  FlatJsonReader json{line};
  while (const auto member = json.next()) {
    result.members.push_back(std::string(member->key) + "=" +
                             (member->number ? std::to_string(*member->number).substr(0, 6) : std::string("-")));
  }
  result.failed = json.failed();
  return result;
}

TEST(FlatJson, reads_each_member_in_order) {
  const Read got = read(R"( { "T" : 1001, "a":-0.5,"s":"te\"xt,}", "yes":true,"no":false, "none":null ,"e":1e-2} )");
  EXPECT_FALSE(got.failed);
  EXPECT_EQ(got.members,
            (std::vector<std::string>{"T=1001.0", "a=-0.500", "s=-", "yes=-", "no=-", "none=-", "e=0.0100"}));
}

TEST(FlatJson, takes_an_empty_object) {
  EXPECT_FALSE(read("{}").failed);
  EXPECT_TRUE(read("{}").members.empty());
}

TEST(FlatJson, refuses_everything_that_is_not_one_flat_object) {
  for (const char* line : {"",
                           " ",
                           "1",
                           "null",
                           "[]",
                           "{",
                           "}",
                           "{]",
                           "{,}",
                           R"({"a"})",
                           R"({"a":})",
                           R"({"a":1,})",
                           R"({"a":1)",
                           R"({"a":1}})",
                           R"({"a":1} x)",
                           R"({"a":1 "b":2})",
                           R"({a:1})",
                           R"({"a":{"b":1}})",
                           R"({"a":[1]})",
                           R"({"a":tru})",
                           R"({"a":nul)",
                           R"({"a)",
                           R"({"a":"b)",
                           R"({"a":"b\)",
                           R"({"a":"b\"})",
                           "{\"a\":\"\x01\"}"}) {
    EXPECT_TRUE(read(line).failed) << line;
  }
}

TEST(FlatJson, takes_only_numbers_that_json_and_a_double_know) {
  for (const char* value : {"0", "-0", "10", "0.5", "-1.25e3", "1E+2", "123456789012345678901234567890", "1e-400"}) {
    const Read got = read(std::string(R"({"a":)") + value + "}");
    // A denormal too small for a double may be refused, never misread.
    if (std::string_view(value) != "1e-400") { EXPECT_FALSE(got.failed) << value; }
  }
  for (const char* value : {"+1", ".5", "1.", "01", "-", "--1", "1e", "1e+", "nan", "NaN", "inf", "-inf", "Infinity",
                            "0x10", "1e999", "-1e999", "1,5", "1 2"}) {
    EXPECT_TRUE(read(std::string(R"({"a":)") + value + "}").failed) << value;
  }
}

TEST(FlatJson, stays_done_and_stays_failed) {
  FlatJsonReader done{"{}"};
  EXPECT_FALSE(done.next());
  EXPECT_FALSE(done.next());
  EXPECT_FALSE(done.failed());
  FlatJsonReader failed{"{\"a\":1;"};
  EXPECT_TRUE(failed.next());
  EXPECT_FALSE(failed.next());
  EXPECT_FALSE(failed.next());
  EXPECT_TRUE(failed.failed());
}

}  // namespace
}  // namespace nacelle::diff_drive
