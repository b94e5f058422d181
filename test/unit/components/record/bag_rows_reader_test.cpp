// SPDX-License-Identifier: Apache-2.0
#include "record/model/bag_rows_reader.hpp"

#include <gtest/gtest.h>

#include "seen_rows.hpp"

namespace nacelle::record {
namespace {

class FakeRows final : public BagRows {
 public:
  const std::vector<BagRowTopic>& topics() const override { return all_topics; }
  const std::vector<BagDefinition>& definitions() const override { return all_definitions; }
  void rewind() override { at_ = 0; }
  Step next(BagMessage& message) override {
    if (at_ == messages.size()) return last;
    message = messages[at_++];
    return Step::Row;
  }

  std::vector<BagRowTopic> all_topics{{7, "/a", "std_msgs/msg/String", "cdr", "depth: 1", "RIHS01_0"},
                                      {9, "/b", "std_msgs/msg/String", "cdr", "", ""},
                                      {2, "/c", "x/msg/Y", "cdr", "", ""}};
  std::vector<BagDefinition> all_definitions{{"std_msgs/msg/String", "ros2msg", "string data"}};
  std::vector<BagMessage> messages{{1, 7, 10, as_bytes("one")}, {2, 2, 5, as_bytes("two")}, {3, 9, 30, ByteView{}}};
  Step last = Step::End;

 private:
  std::size_t at_ = 0;
};

TEST(BagRowsReader, hands_rows_over_as_an_mcap_file_would_be) {
  FakeRows rows;
  const SeenRows seen{rows, [](const std::string& type) { return "of " + type; }};
  EXPECT_TRUE(seen.complete);
  EXPECT_EQ(seen.lines, (std::vector<std::string>{
                            "header ros2", "schema 1 std_msgs/msg/String ros2msg string data",
                            "channel 1 of 1 /a cdr offered_qos_profiles=depth: 1 topic_type_hash=RIHS01_0",
                            "channel 2 of 1 /b cdr", "schema 2 x/msg/Y ros2msg of x/msg/Y", "channel 3 of 2 /c cdr",
                            "message 1 at 10: one", "message 3 at 5: two", "message 2 at 30: "}));
  EXPECT_EQ((SeenRows{rows, nullptr}.lines.size()), seen.lines.size()) << "a second reader begins at the start";
}

TEST(BagRowsReader, leaves_the_schema_of_an_unknown_type_empty) {
  FakeRows rows;
  const SeenRows seen{rows, [](const std::string&) { return std::nullopt; }};
  EXPECT_EQ(seen.lines[4], "schema 2 x/msg/Y  ");
}

TEST(BagRowsReader, reports_rows_that_are_no_messages_and_goes_on) {
  FakeRows rows;
  rows.messages = {{1, std::nullopt, 1, as_bytes("x")},
                   {2, 7, std::nullopt, as_bytes("x")},
                   {3, 7, -1, as_bytes("x")},
                   {4, 7, 1, std::nullopt},
                   {5, 8, 1, as_bytes("x")},
                   {6, 7, 1, as_bytes("good")}};
  const SeenRows seen{rows, nullptr};
  EXPECT_TRUE(seen.complete);
  EXPECT_EQ(seen.problems, (std::vector<std::pair<McapFault, std::uint64_t>>{{McapFault::BadRecord, 1},
                                                                             {McapFault::BadRecord, 2},
                                                                             {McapFault::BadRecord, 3},
                                                                             {McapFault::BadRecord, 4},
                                                                             {McapFault::UnknownChannel, 5}}));
  EXPECT_EQ(seen.lines.back(), "message 1 at 1: good");
}

TEST(BagRowsReader, ends_where_the_database_cannot_be_read) {
  for (const auto& [step, fault] : {std::pair{BagRows::Step::Damaged, McapFault::Truncated},
                                    {BagRows::Step::TooLarge, McapFault::TooLarge},
                                    {BagRows::Step::Unreadable, McapFault::Unreadable}}) {
    FakeRows rows;
    rows.last = step;
    const SeenRows seen{rows, nullptr};
    EXPECT_FALSE(seen.complete);
    EXPECT_EQ(seen.problems, (std::vector<std::pair<McapFault, std::uint64_t>>{{fault, 3}}));
  }
}

}  // namespace
}  // namespace nacelle::record
