// SPDX-License-Identifier: Apache-2.0
#include "record/model/recording_check.hpp"

#include <gtest/gtest.h>

#include "record/protocol/mcap_writer.hpp"
#include "seen_file.hpp"

namespace nacelle::record {
namespace {

/// Messages "good" and "bad" are that; other types than "t" are unknown.
PayloadVerdict look_at(const std::string& type, const std::string&, ByteView bytes) {
  if (type != "t") return PayloadVerdict::UnknownType;
  return as_text(bytes) == "bad" ? PayloadVerdict::Bad : PayloadVerdict::Good;
}

class RecordingCheckTest : public testing::Test {
 protected:
  void SetUp() override {
    McapWriter writer{file_, {.data_crc = true}};
    ASSERT_TRUE(writer.start());
    ASSERT_EQ(writer.add_schema("t", "ros2msg", "x"), 1);
    ASSERT_EQ(writer.add_schema("u", "ros2msg", "y"), 2);
    ASSERT_EQ(writer.add_channel(1, "/a", "cdr", {}), 1);
    ASSERT_EQ(writer.add_channel(2, "/b", "cdr", {}), 2);
    for (std::uint64_t at = 1; at <= 3; ++at) {
      ASSERT_TRUE(writer.write({1, 0, 10 * at, 0, {as_bytes("good")}}));
      ASSERT_TRUE(writer.write({2, 0, 10 * at + 5, 0, {as_bytes("?")}}));
      ASSERT_TRUE(writer.close_chunk());
    }
    ASSERT_TRUE(writer.write_attachment({1, 2, "n", "m", {as_bytes("data")}, 0}));
    ASSERT_TRUE(writer.write_metadata({"meta", {}}));
    ASSERT_TRUE(writer.finish());
  }
  RecordingCheck::Report check() { return RecordingCheck{file_, look_at}.run(); }
  static std::vector<McapFault> faults_of(const RecordingCheck::Report& report) {
    std::vector<McapFault> faults;
    for (const auto& problem : report.problems) faults.push_back(problem.fault);
    return faults;
  }

  MemoryFile file_;
};

TEST_F(RecordingCheckTest, finds_nothing_wrong_in_what_the_writer_wrote) {
  const auto report = check();
  EXPECT_TRUE(report.complete);
  EXPECT_EQ(report.problem_count, 0U) << report.problems.front().what;
  EXPECT_EQ(report.messages, 6U);
  EXPECT_EQ(report.indexed, 6U);
  EXPECT_EQ(report.chunks, 3U);
  EXPECT_EQ(report.attachments, 1U);
  EXPECT_EQ(report.checksums, 6U) << "three chunks, the attachment, the data section, the summary";
  EXPECT_EQ(report.unread, (std::map<std::string, std::uint64_t>{{"u", 3}}));
}

/// Each byte of the file counts: a change of any of them is found, but for bytes that may have any value.
TEST_F(RecordingCheckTest, finds_each_byte_that_was_changed) {
  const Bytes whole = file_.bytes;
  const SeenFile seen{file_};
  std::size_t unnoticed = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    file_.bytes = whole;
    file_.bytes[at] ^= 0x41U;
    if (check().problem_count == 0) ++unnoticed;
  }
  file_.bytes = whole;
  EXPECT_EQ(unnoticed, 0U);
}

TEST_F(RecordingCheckTest, finds_a_file_that_was_cut) {
  file_.bytes.resize(file_.bytes.size() - 9);
  const auto report = check();
  EXPECT_FALSE(report.complete);
  EXPECT_EQ(faults_of(report), std::vector{McapFault::Truncated});
}

TEST(RecordingCheck, asks_for_the_bytes_of_each_message) {
  MemoryFile file;
  McapWriter writer{file, {}};
  ASSERT_TRUE(writer.start());
  ASSERT_EQ(writer.add_schema("t", "ros2msg", "x"), 1);
  ASSERT_EQ(writer.add_channel(1, "/a", "cdr", {}), 1);
  for (const char* data : {"good", "bad", "good"}) ASSERT_TRUE(writer.write({1, 0, 10, 0, {as_bytes(data)}}));
  ASSERT_TRUE(writer.finish());
  const auto report = RecordingCheck{file, look_at}.run();
  EXPECT_EQ(report.problem_count, 1U);
  EXPECT_EQ(report.problems.at(0).fault, McapFault::BadPayload);
}

}  // namespace
}  // namespace nacelle::record
