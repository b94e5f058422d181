// SPDX-License-Identifier: Apache-2.0
#include "record/model/recording_merge.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "record/model/recording_check.hpp"
#include "seen_file.hpp"

namespace nacelle::record {
namespace {

/// Writes messages of these log times to one topic, in chunks of about two.
void write_topic(MemoryFile& file, const std::string& topic, const std::vector<std::uint64_t>& times,
                 const std::string& type = "std_msgs/msg/String") {
  McapWriter writer{file, {.chunk_bytes = 200}};
  ASSERT_TRUE(writer.start());
  ASSERT_EQ(writer.add_schema(type, "ros2msg", "string data"), 1);
  ASSERT_EQ(writer.add_channel(1, topic, "cdr", {{"offered_qos_profiles", "x"}}), 1);
  const std::string data = topic + std::string(60, '.');
  std::uint32_t number = 0;
  for (const auto time : times) ASSERT_TRUE(writer.write({1, number++, time, time + 1, {as_bytes(data)}}));
  ASSERT_TRUE(writer.write_attachment({1, 2, "launch of " + topic, "text/yaml", {as_bytes("launch:")}, 0}));
  ASSERT_TRUE(writer.write_metadata({"rosbag2", {{"a", "b"}}}));
  ASSERT_TRUE(writer.finish());
}

struct Merged {
  std::vector<std::pair<std::uint64_t, std::string>> messages;  // log time, topic
  std::vector<std::string> lines;
  std::uint64_t late = 0;
  std::size_t peak_bytes = 0;
};

Merged merge(const std::vector<MemoryFile*>& files, std::size_t most = RecordingMerge::kMostHeldBytes) {
  std::vector<MergeSource> sources;
  for (MemoryFile* const file : files) {
    RecordingSummary summary;
    EXPECT_TRUE(walk_mcap(*file, summary));
    sources.push_back(
        {[file](McapVisitor& visitor) { return read_mcap(*file, visitor); }, summary.first(), summary.disorder()});
  }
  MemoryFile out;
  McapWriter writer{out, {}};
  EXPECT_TRUE(writer.start());
  RecordingMerge merge{writer, std::move(sources), most};
  EXPECT_TRUE(merge.run());
  EXPECT_TRUE(writer.finish());
  EXPECT_EQ((RecordingCheck{out, nullptr}.run().problem_count), 0U);

  class Reader final : public McapVisitor {
   public:
    explicit Reader(Merged& merged) : merged_(merged) {}
    void on_channel(const McapChannel& channel) override { topics_[channel.id] = channel.topic; }
    void on_message(const McapMessage& message, const McapSpot&) override {
      merged_.messages.emplace_back(message.log_time, topics_[message.channel_id]);
      EXPECT_EQ(message.publish_time, message.log_time + 1);
      EXPECT_EQ(as_text(message.data.bytes).substr(0, topics_[message.channel_id].size()), topics_[message.channel_id]);
    }
    void on_problem(const McapProblem& problem) override { ADD_FAILURE() << problem.what; }

   private:
    Merged& merged_;
    std::map<std::uint16_t, std::string> topics_;
  };
  Merged merged;
  Reader reader{merged};
  EXPECT_TRUE(walk_mcap(out, reader));
  merged.lines = SeenFile{out}.lines;
  merged.late = merge.late();
  merged.peak_bytes = merge.peak_bytes();
  return merged;
}

std::size_t lines_with(const Merged& merged, const std::string& begin) {
  return static_cast<std::size_t>(std::count_if(merged.lines.begin(), merged.lines.end(), [&](const auto& line) {
    return line.compare(0, begin.size(), begin) == 0;
  }));
}

using Messages = std::vector<std::pair<std::uint64_t, std::string>>;

TEST(RecordingMerge, orders_messages_of_all_recordings_by_log_time) {
  MemoryFile a, b, c;
  write_topic(a, "/a", {10, 20, 30, 40, 50});
  write_topic(b, "/b", {5, 15, 45, 46, 47, 60});
  write_topic(c, "/c", {});
  const Merged merged = merge({&a, &b, &c});
  EXPECT_EQ(merged.messages, (Messages{{5, "/b"},
                                       {10, "/a"},
                                       {15, "/b"},
                                       {20, "/a"},
                                       {30, "/a"},
                                       {40, "/a"},
                                       {45, "/b"},
                                       {46, "/b"},
                                       {47, "/b"},
                                       {50, "/a"},
                                       {60, "/b"}}));
  EXPECT_EQ(merged.late, 0U);
}

TEST(RecordingMerge, unites_equal_channels_and_carries_the_rest_over) {
  MemoryFile a, b, c;
  write_topic(a, "/a", {1, 3});
  write_topic(b, "/a", {2, 4});
  write_topic(c, "/c", {5});
  const Merged merged = merge({&a, &b, &c});
  EXPECT_EQ(lines_with(merged, "schema "), 1U);
  EXPECT_EQ(lines_with(merged, "channel "), 2U);
  EXPECT_EQ(lines_with(merged, "message "), 5U);
  EXPECT_EQ(lines_with(merged, "attachment launch of /a"), 2U);
  EXPECT_EQ(lines_with(merged, "attachment launch of /c"), 1U);
  EXPECT_EQ(lines_with(merged, "metadata rosbag2 a=b"), 1U) << "equal metadata once";
}

TEST(RecordingMerge, orders_chunks_that_are_out_of_order) {
  MemoryFile a, b;
  write_topic(a, "/a", {50, 40, 10, 20, 60, 30, 70, 80, 90});
  write_topic(b, "/b", {15, 35, 65});
  const Merged merged = merge({&a, &b});
  EXPECT_TRUE(std::is_sorted(merged.messages.begin(), merged.messages.end()));
  EXPECT_EQ(merged.messages.size(), 12U);
  EXPECT_EQ(merged.late, 0U);
}

TEST(RecordingMerge, holds_a_chunk_of_each_and_no_more) {
  MemoryFile a, b, c;
  std::vector<std::uint64_t> early, late;
  for (std::uint64_t time = 0; time < 1000; ++time) early.push_back(time);
  for (std::uint64_t time = 1000; time < 2000; ++time) late.push_back(time);
  write_topic(a, "/a", early);
  write_topic(b, "/b", early);
  write_topic(c, "/c", late);
  const Merged merged = merge({&a, &b, &c});
  EXPECT_EQ(merged.messages.size(), 3000U);
  EXPECT_TRUE(std::is_sorted(merged.messages.begin(), merged.messages.end(),
                             [](const auto& x, const auto& y) { return x.first < y.first; }));
  EXPECT_LT(merged.peak_bytes, 3000U) << "of 3,000 messages of 62 bytes";
}

TEST(RecordingMerge, writes_late_messages_late_when_it_may_hold_no_more) {
  MemoryFile a;
  std::vector<std::uint64_t> times;
  for (std::uint64_t time = 100; time < 1100; ++time) times.push_back(time);
  times.push_back(50);
  write_topic(a, "/a", times);
  const Merged whole = merge({&a});
  EXPECT_EQ(whole.messages.front().first, 50U);
  EXPECT_EQ(whole.late, 0U);
  const Merged bounded = merge({&a}, 5000);
  EXPECT_EQ(bounded.messages.size(), 1001U);
  EXPECT_EQ(bounded.late, 1U);
  EXPECT_LT(bounded.peak_bytes, 6000U);
}

TEST(RecordingMerge, fails_with_the_writer_and_with_a_recording_that_ends_early) {
  MemoryFile a, full;
  write_topic(a, "/a", {1, 2, 3});
  const auto source = [](MemoryFile& file) {
    return MergeSource{[&file](McapVisitor& visitor) { return read_mcap(file, visitor); }, 1, 0};
  };
  full.room = 100;
  McapWriter no_room{full, {.chunk_bytes = 1}};
  EXPECT_TRUE(no_room.start());
  EXPECT_FALSE((RecordingMerge{no_room, {source(a)}}.run()));

  MemoryFile out;
  McapWriter writer{out, {}};
  EXPECT_TRUE(writer.start());
  a.bytes.resize(a.bytes.size() - 8);
  EXPECT_FALSE((RecordingMerge{writer, {source(a)}}.run()));
}

TEST(RecordingMerge, finds_a_topic_with_two_types) {
  MemoryFile a, b;
  write_topic(a, "/a", {1});
  write_topic(b, "/a", {2}, "std_msgs/msg/Int32");
  RecordingSummary of_a, of_b;
  EXPECT_TRUE(walk_mcap(a, of_a));
  EXPECT_TRUE(walk_mcap(b, of_b));
  EXPECT_FALSE(type_conflict({of_a, of_a}).has_value());
  const auto conflict = type_conflict({of_a, of_a, of_b});
  ASSERT_TRUE(conflict.has_value());
  EXPECT_EQ(conflict->topic, "/a");
  EXPECT_EQ(conflict->types[0], "std_msgs/msg/String");
  EXPECT_EQ(conflict->types[1], "std_msgs/msg/Int32");
  EXPECT_EQ(conflict->recordings[1], 2U);
}

}  // namespace
}  // namespace nacelle::record
