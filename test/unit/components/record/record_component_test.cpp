// SPDX-License-Identifier: Apache-2.0
// The recorder in a container, with publishers of its streams.
#include <algorithm>
#include <atomic>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <map>
#include <rosbag2_interfaces/msg/write_split_event.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <std_msgs/msg/string.hpp>
#include <thread>

#include "nacelle/node/container_facts.hpp"
#include "nacelle/runtime/test_container.hpp"
#include "record/model/bag_metadata.hpp"
#include "record/model/recording_summary.hpp"
#include "record/port/recording_file.hpp"
#include "support/log_lines.hpp"
#include "temporary_folder.hpp"

namespace nacelle::record {
namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using sensor_msgs::msg::Image;
using std_msgs::msg::String;

constexpr const char* kRecorder = "nacelle::record::RecordComponent";

String words(const std::string& text) {
  String message;
  message.data = text;
  return message;
}

class RecordComponentTest : public TemporaryFolder {
 protected:
  runtime::ComponentInfo record(std::map<std::string, ParameterValue> parameters) {
    parameters.emplace("storage.uri", path("bag"));
    parameters.emplace("storage.keep_free", std::int64_t{1});
    return container_.start(kRecorder, std::move(parameters));
  }
  void end(const runtime::ComponentInfo& recorder) {
    EXPECT_EQ(container_.container().trigger(recorder.id, Transition::Deactivate).reason, "");
  }
  /// The number of messages of each topic.
  std::map<std::string, std::uint64_t> recorded(const std::string& file = "bag/bag_0.mcap") {
    auto source = FileSource::open(path(file));
    RecordingSummary summary;
    EXPECT_TRUE(source && walk_mcap(**source, summary)) << file;
    std::map<std::string, std::uint64_t> all;
    for (const auto& [id, topic] : summary.topics()) all[topic.name] += topic.messages;
    return all;
  }

  runtime::TestContainer container_;
};

TEST_F(RecordComponentTest, records_what_is_there_and_what_comes_later) {
  auto before = container_.advertise<String>("/before", QoS(10));
  auto kept = container_.advertise<String>("/kept", QoS(1).transient_local());
  kept.publish(words("from before the recording"));
  const auto recorder = record({{"record.all_topics", true}});
  before.publish(words("a"));
  auto later = container_.advertise<String>("/later", QoS(10).best_effort());
  auto reader = container_.subscribe<DiagnosticArray>("/diagnostics", QoS(10));
  EXPECT_EQ(reader.next().status.front().name, "rosbag2_recorder: recording");  // a second: it knows /later
  later.publish(words("b"));
  later.publish(words("c"));
  end(recorder);
  const auto all = recorded();
  EXPECT_EQ(all.at("/before"), 1U);
  EXPECT_EQ(all.at("/kept"), 1U);
  EXPECT_EQ(all.at("/later"), 2U);
  EXPECT_EQ(all.at("/diagnostics"), 1U);
}

TEST_F(RecordComponentTest, attaches_what_the_run_was_started_with_and_the_robots_description) {
  const auto facts =
      std::static_pointer_cast<ContainerFacts>(container_.container().shared_object(kContainerFactsName));
  facts->read_texts_by([] { return std::vector<RunText>{{"robot.launch.yaml", "application/yaml", "launch: []\n"}}; });
  auto a = container_.advertise<String>("/a", QoS(10));
  const auto recorder = record({{"record.topics", std::vector<std::string>{"/a"}}});
  auto description = container_.advertise<String>("/arm/robot_description", QoS(1).transient_local());
  description.publish(words("<robot name='arm'/>"));
  auto reader = container_.subscribe<DiagnosticArray>("/diagnostics", QoS(10));
  static_cast<void>(reader.next());  // a second
  description.publish(words("<robot name='another'/>"));
  end(recorder);
  EXPECT_EQ(recorded(), (std::map<std::string, std::uint64_t>{}));
  auto source = FileSource::open(path("bag/bag_0.mcap"));
  struct Texts final : McapVisitor {
    void on_attachment(const McapAttachment& one, const McapSpot&) override {
      all[one.name] = std::string{as_text(one.data.bytes)};
    }
    void on_problem(const McapProblem& problem) override { ADD_FAILURE() << problem.what; }
    std::map<std::string, std::string> all;
  } texts;
  ASSERT_TRUE(source && walk_mcap(**source, texts));
  EXPECT_EQ(texts.all, (std::map<std::string, std::string>{{"robot.launch.yaml", "launch: []\n"},
                                                           {"arm/robot_description.urdf", "<robot name='arm'/>"}}));
}

TEST_F(RecordComponentTest, tells_of_another_file_and_of_topics_that_nobody_publishes) {
  using rosbag2_interfaces::msg::WriteSplitEvent;
  auto events = container_.subscribe<WriteSplitEvent>("/events/write_split", QoS(1));
  auto a = container_.advertise<String>("/a", QoS(10));
  const auto recorder = record(
      {{"record.topics", std::vector<std::string>{"/a", "/b"}}, {"storage.max_bagfile_size", std::int64_t{1000}}});
  a.publish(words(std::string(2000, 'x')));
  const WriteSplitEvent event = events.next();
  EXPECT_EQ(event.closed_file, path("bag/bag_0.mcap"));
  EXPECT_EQ(event.opened_file, path("bag/bag_1.mcap"));
  std::vector<std::string> lines;
  {
    const test::LogLines log;
    end(recorder);
    lines = log.all;
  }
  const auto said = [&](const std::string& line) { return std::count(lines.begin(), lines.end(), line); };
  EXPECT_EQ(said("/b was never published"), 1);
  EXPECT_EQ(said("/a was never published"), 0);
}

TEST_F(RecordComponentTest, takes_the_topics_that_are_chosen) {
  auto a = container_.advertise<String>("/a", QoS(10));
  auto b = container_.advertise<String>("/b", QoS(10));
  const auto recorder = record({{"record.topics", std::vector<std::string>{"b"}}});
  a.publish(words("a"));
  b.publish(words("b"));
  end(recorder);
  EXPECT_EQ(recorded(), (std::map<std::string, std::uint64_t>{{"/b", 1}}));
}

// The second publisher's QoS does not fit the reader that the first one got.
TEST_F(RecordComponentTest, reads_a_topic_again_with_what_all_its_publishers_offer) {
  auto reliable = container_.advertise<String>("/a", QoS(10).transient_local());
  reliable.publish(words("1"));
  const auto recorder = record({{"record.all_topics", true}});
  auto loose = container_.advertise<String>("/a", QoS(10).best_effort());
  auto reader = container_.subscribe<DiagnosticArray>("/diagnostics", QoS(10));
  static_cast<void>(reader.next());  // a second
  reliable.publish(words("2"));
  loose.publish(words("3"));
  end(recorder);
  EXPECT_EQ(recorded().at("/a"), 3U) << "none is lost, and none is there twice";
}

// Of messages in a device's memory the reader holds one.
TEST_F(RecordComponentTest, records_a_message_above_a_chunks_size) {
  auto camera = container_.advertise<Image>("/image", QoS(2));
  const auto recorder = record({{"record.all_topics", true}});
  auto reader = container_.subscribe<DiagnosticArray>("/diagnostics", QoS(10));
  static_cast<void>(reader.next());
  Image image;
  image.data.resize(std::size_t{3} << 20U);  // above a chunk's size
  camera.publish(image);
  end(recorder);
  EXPECT_EQ(recorded().at("/image"), 1U);
}

/// An image whose encoding lasts until the test has let it go.
struct SlowImage {
  static const msgs::MessageType& type() {
    static const msgs::MessageType made = [] {
      msgs::MessageType slow = Image::message_type();
      slow.encode = [](const void* message, std::uint8_t* out) {
        begun = true;
        begun.notify_all();
        goes_on.wait(false);
        Image::message_type().encode(message, out);
      };
      return slow;
    }();
    return made;
  }
  static inline std::atomic<bool> begun{false}, goes_on{false};
};

// A camera's driver has few buffers.
TEST_F(RecordComponentTest, holds_one_image_at_most_and_counts_what_it_copies) {
  const auto recorder = record({{"record.topics", std::vector<std::string>{"/image"}}});
  const auto camera =
      container_.container().transport().create_writer({"/image", &SlowImage::type(), QoS(4), "/camera"});
  while (camera->reader_count() == 0) std::this_thread::yield();
  std::uint8_t pixels[4] = {1, 2, 3, 4};
  const auto publish = [&] {
    Block* const block = camera->borrow();
    static_cast<Image*>(block->message)->data.adopt(pixels, 4, 4, {});
    camera->publish(*block);
  };
  publish();
  SlowImage::begun.wait(false);
  publish();  // neither waits beside the one that is encoded
  publish();
  SlowImage::goes_on = true;
  SlowImage::goes_on.notify_all();
  end(recorder);
  auto source = FileSource::open(path("bag/bag_0.mcap"));
  RecordingSummary summary;
  ASSERT_TRUE(source && walk_mcap(**source, summary));
  EXPECT_EQ(summary.messages(), 1U);
  const auto& words = summary.metadata().at(kRecorderRecord);
  EXPECT_EQ(words.at("camera copies"), "1");
  EXPECT_EQ(words.at("lost in queue: /image"), "2");
  EXPECT_EQ(words.at("lost"), "2");
}

TEST_F(RecordComponentTest, makes_a_recording_each_time_it_is_active) {
  const auto recorder = record({{"record.all_topics", true}, {"storage.uri", path("%%%Y")}});
  end(recorder);
  EXPECT_NE(container_.container().trigger(recorder.id, Transition::Activate).reason.find("exists already"),
            std::string::npos);
  std::size_t found = 0;
  for (const auto& entry : std::filesystem::directory_iterator{folder_}) {
    EXPECT_TRUE(entry.path().filename().string().starts_with("%20")) << entry.path();
    ++found;
  }
  EXPECT_EQ(found, 1U);
}

TEST_F(RecordComponentTest, tells_when_it_ends_by_itself) {
  auto a = container_.advertise<String>("/a", QoS(10));
  const auto recorder =
      record({{"record.topics", std::vector<std::string>{"/a"}}, {"storage.keep_free", std::int64_t{1'000'000'000}}});
  auto reader = container_.subscribe<DiagnosticArray>("/diagnostics", QoS(10));
  static_cast<void>(reader.next());
  a.publish(words("for a petabyte"));
  DiagnosticArray report;
  for (int i = 0; i < 5 && (report.status.empty() || report.status.front().level != 2); ++i) report = reader.next();
  ASSERT_EQ(report.status.front().level, 2);
  EXPECT_NE(report.status.front().message.find("the disk is full"), std::string::npos);
  const auto found = container_.container().find(std::to_string(recorder.id));
  ASSERT_TRUE(found);
  ASSERT_EQ(found->open_faults.size(), 1U) << "the robot goes on";
  EXPECT_EQ(found->open_faults.front().code, "RECORDING_ENDED");
  end(recorder);
}

// The recorder takes what came at once, and then sleeps for some milliseconds.
TEST_F(RecordComponentTest, counts_each_message_that_a_burst_loses) {
  auto burst = container_.advertise<String>("/burst", QoS(10));
  const auto recorder = record({{"record.topics", std::vector<std::string>{"/burst"}}});
  constexpr std::uint64_t kMessages = 5000;
  for (std::uint64_t i = 0; i < kMessages; ++i) burst.publish(words("x"));
  std::vector<std::string> lines;
  {
    const test::LogLines log;
    end(recorder);
    lines = log.all;
  }
  std::uint64_t lost = 0;
  for (const std::string& line : lines) {
    if (line.starts_with("lost in queue: ") && line.ends_with(" messages of /burst"))
      lost = std::stoull(line.substr(15));
  }
  EXPECT_GT(lost, 0U);
  EXPECT_EQ(recorded().at("/burst") + lost, kMessages);
}

TEST_F(RecordComponentTest, refuses_what_it_cannot_do) {
  const auto refused = [&](std::map<std::string, ParameterValue> parameters) -> std::string {
    std::string why;
    try {
      record(std::move(parameters));
    } catch (const std::runtime_error& error) { why = error.what(); }
    EXPECT_TRUE(container_.container().unload(container_.container().find("rosbag2_recorder")->id));
    return why;
  };
  EXPECT_NE(refused({}).find("no topic is chosen"), std::string::npos);
  EXPECT_NE(refused({{"record.regex", std::string{"("}}}).find("is no regular expression"), std::string::npos);
  EXPECT_NE(refused({{"record.all_topics", true}, {"storage.compression", std::string{"gzip"}}}).find("'gzip'"),
            std::string::npos);
  EXPECT_NE(refused({{"record.all_topics", true}, {"storage.storage_id", std::string{"sqlite3"}}}).find("sqlite3"),
            std::string::npos);
  EXPECT_NE(refused({{"record.all_topics", true}, {"storage.uri", std::string{"/proc/bag"}}}).find("cannot be made"),
            std::string::npos);
}

}  // namespace
}  // namespace nacelle::record
