// SPDX-License-Identifier: Apache-2.0
#include "record/model/recording_summary.hpp"

#include <gtest/gtest.h>

#include "record/model/recording_copy.hpp"
#include "record/protocol/mcap_writer.hpp"
#include "seen_file.hpp"

namespace nacelle::record {
namespace {

constexpr std::uint64_t kSecond = 1'000'000'000U;

/// /scan at 10 Hz for 2 s with a gap of 0.5 s, /odom once, /never not at all.
void write_drive(MemoryFile& file, Compression compression = Compression::None) {
  McapWriter writer{file, {.compression = compression, .chunk_bytes = 500}};
  ASSERT_TRUE(writer.start());
  ASSERT_EQ(writer.add_schema("sensor_msgs/msg/LaserScan", "ros2msg", "x"), 1);
  ASSERT_EQ(writer.add_schema("nav_msgs/msg/Odometry", "ros2msg", "y"), 2);
  ASSERT_EQ(writer.add_channel(1, "/scan", "cdr", {{"topic_type_hash", "RIHS01_0"}}), 1);
  ASSERT_EQ(writer.add_channel(2, "/odom", "cdr", {}), 2);
  ASSERT_EQ(writer.add_channel(2, "/never", "cdr", {}), 3);
  for (std::uint32_t number = 0; number <= 20; ++number) {
    if (number >= 6 && number <= 9) continue;
    const std::uint64_t at = 100 * kSecond + number * kSecond / 10;
    ASSERT_TRUE(writer.write({1, number, at, at, {as_bytes("0123456789")}}));
  }
  ASSERT_TRUE(writer.write({2, 0, 99 * kSecond, 99 * kSecond, {as_bytes("abc")}}));
  ASSERT_TRUE(writer.write_attachment({1, 2, "robot.launch.yaml", "text/yaml", {as_bytes("launch:")}, 0}));
  ASSERT_TRUE(writer.write_metadata({"rosbag2", {{"a", "b"}}}));
  ASSERT_TRUE(writer.finish());
}

TEST(RecordingSummary, counts_and_times_each_topic) {
  MemoryFile file;
  write_drive(file, Compression::Zstd);
  RecordingSummary summary;
  EXPECT_TRUE(walk_mcap(file, summary));
  EXPECT_TRUE(summary.problems().empty());
  EXPECT_EQ(summary.profile(), "ros2");
  EXPECT_EQ(summary.compression(), "zstd");
  EXPECT_EQ(summary.messages(), 18U);
  EXPECT_EQ(summary.first(), 99 * kSecond);
  EXPECT_EQ(summary.last(), 102 * kSecond);
  ASSERT_EQ(summary.topics().size(), 3U) << "the summary of the file names a topic without messages, too";
  const RecordedTopic& scan = summary.topics().at(1);
  EXPECT_EQ(scan.name, "/scan");
  EXPECT_EQ(scan.type, "sensor_msgs/msg/LaserScan");
  EXPECT_EQ(scan.messages, 17U);
  EXPECT_EQ(scan.bytes, 170U);
  EXPECT_EQ(scan.longest_gap, kSecond / 2);
  EXPECT_EQ(scan.gap_at, 100 * kSecond + kSecond / 2);
  EXPECT_NEAR(scan.rate_hz(), 8.0, 1e-9) << "16 intervals in 2 s";
  EXPECT_EQ(summary.topics().at(2).rate_hz(), 0.0) << "of one message";
  EXPECT_EQ(summary.topics().at(3).messages, 0U);
  ASSERT_EQ(summary.attachments().size(), 1U);
  EXPECT_EQ(summary.attachments()[0].bytes, 7U);
  EXPECT_EQ(summary.metadata().at("rosbag2").at("a"), "b");
}

TEST(RecordingSummary, keeps_the_first_hundred_problems) {
  Bytes bytes{std::begin(kMcapMagic), std::end(kMcapMagic)};
  for (int record = 0; record < 1000; ++record) bytes.insert(bytes.end(), kMcapRecordHead, 0);
  MemoryFile file{bytes};
  RecordingSummary summary;
  EXPECT_FALSE(walk_mcap(file, summary));
  EXPECT_EQ(summary.problems().size(), RecordingSummary::kMostProblems);
}

TEST(RecordingCopy, of_a_whole_file_has_the_same_messages) {
  MemoryFile file, copied;
  write_drive(file);
  McapWriter writer{copied, {.compression = Compression::Lz4}};
  RecordingCopy copy{writer};
  ASSERT_TRUE(writer.start());
  EXPECT_TRUE(walk_mcap(file, copy));
  ASSERT_TRUE(writer.finish());
  EXPECT_FALSE(copy.has_failed());
  EXPECT_EQ(copy.messages(), 18U);
  const SeenFile before{file}, after{copied};
  EXPECT_EQ(after.problems, std::vector<McapFault>{});
  const auto messages_of = [](const SeenFile& seen) {
    std::vector<std::string> all;
    for (const auto& line : seen.lines) {
      if (line.rfind("message ", 0) == 0 || line.rfind("attachment ", 0) == 0 || line.rfind("metadata ", 0) == 0)
        all.push_back(line);
    }
    return all;
  };
  EXPECT_EQ(messages_of(after), messages_of(before));
  EXPECT_EQ(after.chunk_spots.size(), before.chunk_spots.size());
}

TEST(RecordingCopy, of_a_file_that_was_cut_is_a_whole_one) {
  MemoryFile file, copied;
  write_drive(file);
  file.bytes.resize(file.bytes.size() * 2 / 3);
  McapWriter writer{copied, {}};
  RecordingCopy copy{writer};
  ASSERT_TRUE(writer.start());
  EXPECT_FALSE(walk_mcap(file, copy));
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(copy.problems(), 1U);
  EXPECT_GT(copy.messages(), 0U);
  const SeenFile after{copied};
  EXPECT_TRUE(after.complete);
  EXPECT_EQ(after.statistics.message_count, copy.messages());
}

TEST(RecordingCopy, notices_a_full_disk) {
  MemoryFile file, copied;
  write_drive(file);
  copied.room = 300;
  McapWriter writer{copied, {}};
  RecordingCopy copy{writer};
  ASSERT_TRUE(writer.start());
  walk_mcap(file, copy);
  EXPECT_TRUE(copy.has_failed());
}

}  // namespace
}  // namespace nacelle::record
