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

/// Times of the messages of each topic, in the order of the file.
struct TimesOfTopics final : McapVisitor {
  void on_channel(const McapChannel& channel) override { names[channel.id] = channel.topic; }
  void on_message(const McapMessage& message, const McapSpot&) override {
    EXPECT_LE(message.publish_time, message.log_time);
    all[names[message.channel_id]].push_back(message.log_time);
  }
  void on_problem(const McapProblem& problem) override { ADD_FAILURE() << problem.what; }
  std::map<std::uint16_t, std::string> names;
  std::map<std::string, std::vector<std::uint64_t>> all;
};

TEST_F(RecordingTest, after_a_split_repeats_what_publishers_keep) {
  for (const bool repeats : {true, false}) {
    SCOPED_TRACE(repeats);
    std::filesystem::remove_all(path("bag"));
    auto recording = begin({.max_file_bytes = 10'000, .repeats_latched = repeats});
    const auto keep = [&](std::uint64_t writer, std::uint64_t at) {
      String message;
      const auto topic = recording->add_topic("/tf_static", String::message_type(), {QoS(2).transient_local()});
      recording->write(topic, &message, {at, at, writer});
    };
    keep(1, 1);
    keep(1, 2);
    keep(1, 3);  // the first one is not kept any more
    keep(2, 4);
    say(*recording, std::string(12'000, 'x'), 5);  // a split
    keep(2, 6);
    say(*recording, std::string(12'000, 'x'), 7);
    EXPECT_EQ(recording->files(), 3U);
    EXPECT_FALSE(recording->finish());
    const auto times = [&](int file) {
      TimesOfTopics seen;
      auto source = FileSource::open(path("bag/bag_" + std::to_string(file) + ".mcap"));
      EXPECT_TRUE(source && walk_mcap(**source, seen));
      return seen.all["/tf_static"];
    };
    using Stamps = std::vector<std::uint64_t>;
    EXPECT_EQ(times(0), (Stamps{1, 2, 3, 4}));
    EXPECT_EQ(times(1), repeats ? (Stamps{5, 5, 5, 6}) : Stamps{6}) << "with the time of the last message before";
    EXPECT_EQ(times(2), repeats ? (Stamps{7, 7, 7, 7}) : Stamps{});
    EXPECT_EQ(metadata()["message_count"].as<int>(), repeats ? 14 : 7);
  }
}

TEST_F(RecordingTest, what_publishers_keep_does_not_split_it_again) {
  auto recording = begin({.max_file_bytes = 10'000});
  String map;
  map.data = std::string(20'000, 'm');
  const auto topic = recording->add_topic("/map", String::message_type(), {QoS(1).transient_local()});
  recording->write(topic, &map, {1, 1, 1});
  EXPECT_EQ(recording->files(), 2U);
  for (std::uint64_t at = 2; at < 10; ++at) say(*recording, "a", at);
  EXPECT_EQ(recording->files(), 2U) << "the map alone is above the limit";
  EXPECT_FALSE(recording->finish());
}

TEST_F(RecordingTest, says_at_its_end_what_it_is_told) {
  auto recording = begin();
  recording->say_at_end({{"lost", "1"}});
  recording->split();
  recording->say_at_end({{"lost", "2"}});
  EXPECT_FALSE(recording->finish());
  EXPECT_EQ(summary_of(0).metadata().count(kRecorderRecord), 0U);
  EXPECT_EQ(summary_of(1).metadata().at(kRecorderRecord).at("lost"), "2");
}

TEST(KeptMessages, are_the_last_ones_of_each_publisher_within_their_bytes) {
  KeptMessages kept{10};
  const auto first_bytes = [&] {
    std::string all;
    for (const auto& one : kept.all()) all += static_cast<char>(one.bytes.front());
    return all;
  };
  kept.keep(0, 1, as_bytes("a12"), 2);
  kept.keep(0, 2, as_bytes("b12"), 2);
  kept.keep(1, 1, as_bytes("c12"), 2);
  EXPECT_EQ(first_bytes(), "abc");
  kept.keep(0, 1, as_bytes("d"), 1);
  EXPECT_EQ(first_bytes(), "bcd") << "one of its publisher";
  kept.keep(0, 1, as_bytes("e12345"), 2);
  EXPECT_EQ(first_bytes(), "cde") << "the oldest goes where there is no room";
  kept.keep(0, 1, as_bytes("f1234567890"), 9);
  EXPECT_EQ(first_bytes(), "cde") << "too long alone";
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
