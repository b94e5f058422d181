// SPDX-License-Identifier: Apache-2.0
#include "record/component/recording.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <std_msgs/msg/string.hpp>

#include "record/model/recording_summary.hpp"
#include "seen_file.hpp"
#include "temporary_folder.hpp"

namespace nacelle::record {
namespace {

using std_msgs::msg::String;

class RecordingTest : public TemporaryFolder {
 protected:
  std::unique_ptr<Recording> begin(RecordingOptions options = {}) {
    options.folder = path("bag");
    options.keep_free = 0;
    auto made = Recording::begin(options);
    EXPECT_TRUE(made) << made.error().text();
    return made ? std::move(*made) : nullptr;
  }
  static void say(Recording& recording, const std::string& words, std::uint64_t at) {
    String message;
    message.data = words;
    recording.write(recording.add_topic("/chatter", String::message_type(), {QoS(10)}), &message, {at, at - 1});
  }
  [[nodiscard]] const RecordingSummary& summary_of(int file) {
    auto source = FileSource::open(path("bag/bag_" + std::to_string(file) + ".mcap"));
    summary_ = std::make_unique<RecordingSummary>();
    EXPECT_TRUE(source && walk_mcap(**source, *summary_));
    EXPECT_TRUE(summary_->problems().empty());
    return *summary_;
  }
  [[nodiscard]] YAML::Node metadata() const {
    return YAML::LoadFile(path("bag/metadata.yaml"))["rosbag2_bagfile_information"];
  }

 private:
  std::unique_ptr<RecordingSummary> summary_;
};

TEST_F(RecordingTest, is_a_folder_as_rosbag2_makes_it) {
  auto recording = begin();
  say(*recording, "hello", 100);
  say(*recording, "world", 300);
  EXPECT_EQ(recording->messages(), 2U);
  EXPECT_FALSE(recording->finish());
  EXPECT_FALSE(recording->finish()) << "once more";
  const auto& summary = summary_of(0);
  EXPECT_EQ(summary.messages(), 2U);
  EXPECT_EQ(summary.profile(), "ros2");
  ASSERT_EQ(summary.topics().size(), 1U);
  const auto& topic = summary.topics().begin()->second;
  EXPECT_EQ(topic.name, "/chatter");
  EXPECT_EQ(topic.type, "std_msgs/msg/String");
  EXPECT_EQ(metadata()["message_count"].as<int>(), 2);
  EXPECT_EQ(metadata()["duration"]["nanoseconds"].as<int>(), 200);

  auto source = FileSource::open(recording->file());
  ASSERT_TRUE(source);
  const SeenFile seen{**source};
  const auto has = [&](const std::string& part) {
    return std::any_of(seen.lines.begin(), seen.lines.end(),
                       [&](const auto& line) { return line.find(part) != std::string::npos; });
  };
  EXPECT_TRUE(has("schema 1 std_msgs/msg/String ros2msg string data"));
  EXPECT_TRUE(has("- history: keep_last"));
  EXPECT_TRUE(has("topic_type_hash=RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"));
  EXPECT_TRUE(has("message 1 #0 at 300 of 299: "));
  EXPECT_TRUE(has("metadata rosbag2 serialized_metadata=rosbag2_bagfile_information:"));
}

TEST_F(RecordingTest, has_what_is_attached_beside_its_messages) {
  auto recording = begin();
  recording->attach({"robot.launch.yaml", "application/yaml", "launch: []\n"}, 5);
  say(*recording, "hello", 100);
  recording->attach({"robot_description.urdf", "application/xml", "<robot/>"}, 200);
  say(*recording, "world", 300);
  EXPECT_FALSE(recording->finish());
  const auto& summary = summary_of(0);
  EXPECT_EQ(summary.messages(), 2U);
  ASSERT_EQ(summary.attachments().size(), 2U);
  EXPECT_EQ(summary.attachments()[0].name, "robot.launch.yaml");
  EXPECT_EQ(summary.attachments()[0].bytes, 11U);
  EXPECT_EQ(summary.attachments()[1].media_type, "application/xml");
}

TEST_F(RecordingTest, never_touches_what_is_there) {
  std::filesystem::create_directory(path("bag"));
  const auto refused = Recording::begin({.folder = path("bag")});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("exists already"), std::string::npos);
  EXPECT_FALSE(Recording::begin({.folder = "/proc/bag"}));
  EXPECT_TRUE(Recording::begin({.folder = path("new/deep/bag"), .keep_free = 0}));
}

TEST_F(RecordingTest, continues_in_another_file_by_size_time_and_order) {
  auto recording = begin({.max_file_bytes = 10'000, .max_file_duration = 60s});
  const std::string words(6000, 'x');
  say(*recording, words, 1);
  say(*recording, words, 2);  // 12 kB
  EXPECT_EQ(recording->files(), 2U);
  say(*recording, "a", 3);
  say(*recording, "b", 60'000'000'003);  // a minute
  EXPECT_EQ(recording->files(), 3U);
  recording->split();
  EXPECT_EQ(recording->files(), 4U);
  say(*recording, "c", 60'000'000'004);
  EXPECT_FALSE(recording->finish());
  EXPECT_EQ(summary_of(0).messages(), 2U);
  EXPECT_EQ(summary_of(1).messages(), 2U);
  EXPECT_EQ(summary_of(2).messages(), 0U);
  EXPECT_EQ(summary_of(3).messages(), 1U);
  EXPECT_EQ(summary_of(3).topics().size(), 1U) << "each file describes its topics";
  EXPECT_EQ(metadata()["files"].size(), 4U);
  EXPECT_EQ(metadata()["message_count"].as<int>(), 5);
}

TEST_F(RecordingTest, closes_a_chunk_after_a_second) {
  auto recording = begin();
  const MonotonicTime start{100s};
  recording->look_at_time(start);
  say(*recording, "hello", 1);
  recording->look_at_time(start + 999ms);
  recording->flush();
  const auto before = std::filesystem::file_size(recording->file());
  recording->look_at_time(start + 1s);
  say(*recording, "not in it", 2);
  recording->flush();
  EXPECT_GT(std::filesystem::file_size(recording->file()), before);
  // What would be left if the machine stopped now.
  RecordingSummary summary;
  auto now = FileSource::open(recording->file());
  EXPECT_FALSE(walk_mcap(**now, summary)) << "it has no end yet";
  EXPECT_EQ(summary.messages(), 1U);
}

TEST_F(RecordingTest, ends_before_the_disk_is_full_and_is_complete) {
  auto recording = Recording::begin({.folder = path("bag"), .keep_free = std::uint64_t{1} << 60U});
  ASSERT_TRUE(recording);
  (*recording)->flush();  // the file system is asked after a write
  say(**recording, "hello", 1);
  ASSERT_TRUE((*recording)->problem());
  EXPECT_NE((*recording)->problem()->text().find("the disk is full"), std::string::npos);
  say(**recording, "later", 5);
  EXPECT_EQ((*recording)->messages(), 0U);
  EXPECT_TRUE((*recording)->finish());
  EXPECT_EQ(summary_of(0).messages(), 0U);
  EXPECT_EQ(metadata()["message_count"].as<int>(), 0);
}

TEST_F(RecordingTest, loses_and_counts_what_a_slow_disk_has_no_room_for) {
  auto recording = begin({.most_waiting = 5000});
  for (std::uint64_t i = 1; i <= 10; ++i) say(*recording, std::string(1000, 'x'), i);
  const auto& topic = recording->topics().front();
  EXPECT_GT(topic.lost, 0U) << "the open chunk waits, too";
  EXPECT_EQ(topic.lost + topic.known.messages, 10U);
  EXPECT_FALSE(recording->finish());
  EXPECT_EQ(summary_of(0).messages(), topic.known.messages);
}

}  // namespace
}  // namespace nacelle::record
