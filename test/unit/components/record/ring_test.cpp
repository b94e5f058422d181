// SPDX-License-Identifier: Apache-2.0
#include "record/component/ring.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <std_msgs/msg/string.hpp>

#include "record/component/snapshot.hpp"
#include "record/model/recording_check.hpp"
#include "record/model/recording_summary.hpp"
#include "record/port/recording_file.hpp"
#include "temporary_folder.hpp"

namespace nacelle::record {
namespace {

using std_msgs::msg::String;

class RingTest : public TemporaryFolder {
 protected:
  std::unique_ptr<Ring> begin(RingOptions options = {}) {
    options.base = folder_;
    options.name = "robot.recorder";
    auto made = Ring::begin(options);
    EXPECT_TRUE(made) << made.error().text();
    return made ? std::move(*made) : nullptr;
  }
  static void say(Ring& ring, const std::string& words, std::uint64_t at, std::uint64_t writer = 1) {
    String message;
    message.data = words;
    ring.write(ring.add_topic("/chatter", String::message_type(), {QoS(10)}), &message, {at, at, writer});
  }
  static void latch(Ring& ring, const std::string& words, std::uint64_t at, std::uint64_t writer = 1) {
    String message;
    message.data = words;
    ring.write(ring.add_topic("/map", String::message_type(), {QoS(1).transient_local()}), &message, {at, at, writer});
  }
  /// A chunk with this text, at a second of its own.
  static void chunk(Ring& ring, const std::string& words, std::uint64_t second) {
    ring.look_at_time(MonotonicTime{1s * second});
    say(ring, words, second);
    ring.look_at_time(MonotonicTime{1s * second + 1s});
  }
  Result<Snapshot, Problem> snapshot(const std::vector<std::string>& files) {
    return write_snapshot({.files = files, .folder = path("bag"), .reason = "a test"});
  }
  Result<Snapshot, Problem> snapshot(const Ring::Files& content) {
    std::vector<std::string> files;
    for (const auto& file : content) files.push_back(file->path());
    return snapshot(files);
  }
  /// The log times of each topic. The file must be good.
  std::map<std::string, std::vector<std::uint64_t>> times(const Snapshot& made) {
    struct Times final : McapVisitor {
      void on_channel(const McapChannel& channel) override { names[channel.id] = channel.topic; }
      void on_message(const McapMessage& message, const McapSpot&) override {
        all[names[message.channel_id]].push_back(message.log_time);
      }
      void on_problem(const McapProblem& problem) override { ADD_FAILURE() << problem.what; }
      std::map<std::uint16_t, std::string> names;
      std::map<std::string, std::vector<std::uint64_t>> all;
    } seen;
    const std::string name = made.folder.substr(made.folder.rfind('/') + 1) + "_0.mcap";
    auto source = FileSource::open(made.folder + "/" + name);
    if (!source) {
      ADD_FAILURE() << source.error().text();
      return {};
    }
    const auto report = RecordingCheck{**source, nullptr}.run();
    EXPECT_EQ(report.problem_count, 0U);
    EXPECT_TRUE(report.complete);
    walk_mcap(**source, seen);
    return seen.all;
  }
  std::vector<std::string> files_in(const std::string& folder) {
    std::vector<std::string> all;
    for (const auto& entry : std::filesystem::directory_iterator{folder}) all.push_back(entry.path().string());
    std::sort(all.begin(), all.end());
    return all;
  }
};

TEST_F(RingTest, drops_chunks_that_are_older_than_it_may_reach) {
  auto ring = begin({.longest = 5s});
  for (std::uint64_t second = 1; second <= 20; ++second) chunk(*ring, "x", second);
  EXPECT_EQ(ring->reach(), std::optional<Duration>{6s}) << "from the begin of the oldest chunk";
  const auto made = snapshot(ring->content());
  ASSERT_TRUE(made) << made.error().text();
  EXPECT_EQ(times(*made).at("/chatter"), (std::vector<std::uint64_t>{15, 16, 17, 18, 19, 20}));
  EXPECT_EQ(made->problems, 0U);
}

TEST_F(RingTest, never_has_more_bytes_than_it_may) {
  auto ring = begin({.longest = 1h, .most_bytes = 100'000});
  for (std::uint64_t second = 1; second <= 50; ++second) {
    chunk(*ring, std::string(20'000, 'x'), second);
    std::uint64_t there = 0;
    for (const auto& file : files_in(ring->folder())) there += std::filesystem::file_size(file);
    EXPECT_EQ(there, ring->bytes());
    ASSERT_LE(there, 100'000U);
  }
  EXPECT_EQ(ring->files(), 4U);
  const auto made = snapshot(ring->content());
  ASSERT_TRUE(made);
  EXPECT_EQ(times(*made).at("/chatter"), (std::vector<std::uint64_t>{47, 48, 49, 50}));
  say(*ring, std::string(100'000, 'x'), 60);
  EXPECT_EQ(ring->topics().front().lost, 1U) << "larger than the ring";
}

TEST_F(RingTest, keeps_what_publishers_keep_for_late_readers) {
  auto ring = begin({.longest = 2s});
  ring->look_at_time(MonotonicTime{1s});
  latch(*ring, "an old one of the first publisher", 1, 1);
  latch(*ring, "the first publisher's", 2, 1);
  latch(*ring, "the second publisher's", 3, 2);
  for (std::uint64_t second = 10; second <= 20; ++second) chunk(*ring, "x", second);
  latch(*ring, "the second one's, again, within the ring's seconds", 21, 2);
  const auto made = snapshot(ring->content());
  ASSERT_TRUE(made);
  const auto all = times(*made);
  EXPECT_EQ(all.at("/map"), (std::vector<std::uint64_t>{2, 21})) << "each once";
  EXPECT_EQ(all.at("/chatter").front(), 18U);
}

TEST_F(RingTest, has_what_is_attached_in_each_snapshot) {
  auto ring = begin({.longest = 2s, .most_bytes = 100'000});
  ring->attach({"robot.launch.yaml", "application/yaml", "launch: []\n"}, 5);
  ring->attach({"large.yaml", "application/yaml", std::string(26'000, 'x')}, 5);
  for (std::uint64_t second = 10; second <= 20; ++second) chunk(*ring, std::string(20'000, 'x'), second);
  EXPECT_LE(ring->bytes(), 100'000U);
  for (int round = 0; round < 2; ++round) {
    const auto made = snapshot(ring->content());
    ASSERT_TRUE(made);
    EXPECT_EQ(times(*made).size(), 1U);
    auto source = FileSource::open(made->folder + made->folder.substr(made->folder.rfind('/')) + "_0.mcap");
    RecordingSummary summary;
    ASSERT_TRUE(source && walk_mcap(**source, summary));
    ASSERT_EQ(summary.attachments().size(), 1U) << "at most a quarter of the ring";
    EXPECT_EQ(summary.attachments().front().name, "robot.launch.yaml");
  }
}

TEST_F(RingTest, forgets_kept_messages_above_half_of_its_bytes) {
  auto ring = begin({.most_bytes = 100'000});
  for (std::uint64_t writer = 1; writer <= 20; ++writer) latch(*ring, std::string(9'000, 'x'), writer, writer);
  EXPECT_LE(ring->bytes(), 300'000U);
  ring->look_at_time(MonotonicTime{5s});
  ring->look_at_time(MonotonicTime{100s});
  std::uint64_t there = 0;
  for (const auto& file : files_in(ring->folder())) there += std::filesystem::file_size(file);
  EXPECT_LE(there, 50'000U);
  const auto made = snapshot(ring->content());
  ASSERT_TRUE(made);
  EXPECT_EQ(times(*made).at("/map").back(), 20U);
}

TEST_F(RingTest, goes_on_while_a_snapshot_holds_its_chunks) {
  auto ring = begin({.longest = 2s});
  for (std::uint64_t second = 1; second <= 3; ++second) chunk(*ring, "x", second);
  auto held = ring->content();
  const std::string folder = ring->folder();
  for (std::uint64_t second = 10; second <= 12; ++second) chunk(*ring, "x", second);
  ring.reset();
  const auto made = snapshot(held);
  ASSERT_TRUE(made);
  EXPECT_EQ(times(*made).at("/chatter"), (std::vector<std::uint64_t>{1, 2, 3}));
  held.clear();
  EXPECT_FALSE(std::filesystem::exists(folder)) << "nothing stays";
}

TEST_F(RingTest, is_private_and_gone_with_its_recorder) {
  auto ring = begin();
  chunk(*ring, "x", 1);
  const std::string folder = ring->folder();
  struct stat status {};
  ASSERT_EQ(::lstat(folder.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777U, 0700U);
  ASSERT_EQ(::lstat(files_in(folder).front().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777U, 0600U);
  ring.reset();
  EXPECT_TRUE(files_in(folder_).empty());
}

TEST_F(RingTest, says_that_there_is_no_room) {
  auto none = Ring::begin({.base = path("none"), .name = "a"});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code.text(), "file.not_found");
  EXPECT_FALSE(Ring::begin({.base = "/proc", .name = "a"}));
}

TEST_F(RingTest, writes_many_snapshots_beside_each_other) {
  auto ring = begin();
  chunk(*ring, "x", 1);
  EXPECT_EQ(snapshot(ring->content())->folder, path("bag"));
  EXPECT_EQ(snapshot(ring->content())->folder, path("bag_2"));
  EXPECT_TRUE(std::filesystem::exists(path("bag_2/metadata.yaml")));
  EXPECT_TRUE(std::filesystem::exists(path("bag_2/bag_2_0.mcap")));
  const auto full = write_snapshot({.files = {}, .folder = path("full"), .keep_free = std::uint64_t{1} << 60U});
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().code.text(), "file.no_room");
  EXPECT_FALSE(std::filesystem::exists(path("full")));
}

// What a killed process leaves, in all its states.
class LeftRingTest : public RingTest {
 protected:
  /// Copies of a ring's files.
  std::vector<std::string> left() {
    auto ring = begin();
    ring->look_at_time(MonotonicTime{1s});
    latch(*ring, "kept", 1);
    for (std::uint64_t second = 2; second <= 5; ++second) chunk(*ring, "some words", second);
    std::filesystem::create_directory(path("left"));
    for (const auto& file : ring->content()) {
      const std::filesystem::path from{file->path()};
      std::filesystem::copy_file(from, path("left") + "/" + from.filename().string());
    }
    return files_in(path("left"));
  }
};

TEST_F(LeftRingTest, is_written_but_for_the_chunk_that_was_being_written) {
  const auto files = left();
  ASSERT_EQ(files.size(), 6U) << "the kept message, its chunk, and four more";
  const auto whole = std::filesystem::file_size(files[4]);
  for (const std::uintmax_t left : {whole - 50, whole / 2, std::uintmax_t{1}, std::uintmax_t{0}}) {
    std::filesystem::resize_file(files[4], left);
    const auto made = snapshot(files);
    ASSERT_TRUE(made);
    const auto seen = times(*made);
    EXPECT_EQ(seen.at("/map"), std::vector<std::uint64_t>{1});
    EXPECT_EQ(seen.at("/chatter"), (std::vector<std::uint64_t>{2, 3, 4}));
  }
}

TEST_F(LeftRingTest, with_damaged_bytes_gives_whole_messages_only) {
  const auto files = left();
  std::ifstream in{files[1], std::ios::binary};
  const std::string good{std::istreambuf_iterator<char>{in}, {}};
  for (std::size_t at = 0; at < good.size(); at += 3) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x55);
    std::ofstream{files[1], std::ios::binary} << bad;
    const auto made = snapshot(files);
    ASSERT_TRUE(made) << at;
    std::uint64_t others = 0;
    const auto seen = times(*made).at("/chatter");
    for (const auto time : seen) others += time != 2 ? 1 : 0;
    ASSERT_EQ(others, 3U) << at;
    std::filesystem::remove_all(made->folder);
  }
}

TEST_F(LeftRingTest, that_is_no_ring_is_refused) {
  std::ofstream{path(chunk_name(1))} << "no MCAP file at all";
  const auto refused = snapshot({path(chunk_name(1))});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("nothing that can be read"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(path("bag")));
}

TEST(RingOrder, has_kept_messages_before_chunks_and_none_twice) {
  const auto ordered = in_ring_order({"/a/" + chunk_name(7), "/a/" + kept_name(2, 7), "/a/" + kept_name(1, 3),
                                      "/a/" + kept_name(0, 4), "/a/" + chunk_name(6), "/a/" + attached_name(0),
                                      "/a/other.mcap", "/a/kept_1.mcap", "/a/" + chunk_name(8) + ".old"});
  EXPECT_EQ(ordered, (std::vector<std::string>{"/a/" + attached_name(0), "/a/" + kept_name(0, 4),
                                               "/a/" + kept_name(1, 3), "/a/" + chunk_name(6), "/a/" + chunk_name(7)}));
}

}  // namespace
}  // namespace nacelle::record
