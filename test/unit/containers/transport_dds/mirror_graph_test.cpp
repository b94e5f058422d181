// SPDX-License-Identifier: Apache-2.0
// What one of two graphs that only the network joins knows of the other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>

#include "mirrored.hpp"

namespace nacelle {
namespace {

using test::hear;
using test::Mirror;
using test::say;
using test::Texts;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST_F(Mirror, names_a_node_that_another_participant_has_too_once_with_its_program) {
  test::MirroredBroker twin{"talker"};
  auto ours = here.writer("/ours");
  auto not_ours = there.writer("/not_ours");
  auto theirs = twin.writer("/theirs");
  ASSERT_TRUE(until([&] { return here.mirror->namesakes().size() == 1 && twin.mirror->namesakes().size() == 1; }));
  const Namesake found = here.mirror->namesakes().front();
  EXPECT_EQ(found.node, "/talker");
  EXPECT_EQ(found.pid, std::to_string(::getpid()));
  EXPECT_NE(found.host, "");
  ASSERT_TRUE(until([&] { return here.problems.lock()->size() == 1; }));
  EXPECT_THAT(here.problems.lock()->front(),
              ::testing::AllOf(::testing::StartsWith("/talker: two nodes of this name"), HasSubstr("ROS_DOMAIN_ID")));
  auto more = twin.writer("/more");
  theirs.reset();
  more.reset();
  EXPECT_TRUE(until([&] { return here.mirror->namesakes().empty(); })) << "its node has gone with its last end";
  EXPECT_EQ(here.problems.lock()->size(), 1U);
  EXPECT_TRUE(there.mirror->namesakes().empty());
  EXPECT_TRUE(there.problems.lock()->empty());
}

TEST_F(Mirror, tells_of_a_second_robot_with_the_same_nodes_in_one_line) {
  test::MirroredBroker twin{"talker"};
  std::vector<std::unique_ptr<Writer>> writers;
  for (auto* const side : {&here, &twin}) {
    for (const char* const node : {"/ekf", "/imu", "/lidar"}) {
      EndpointSpec spec = side->spec(std::string{"/topic_of"} + node + (side == &here ? "/here" : "/twin"));
      spec.node = node;
      writers.push_back(side->broker.create_writer(spec));
    }
  }
  ASSERT_TRUE(until([&] { return here.mirror->namesakes().size() == 3; }));
  ASSERT_EQ(here.problems.lock()->size(), 1U);
  EXPECT_THAT(here.problems.lock()->front(), HasSubstr("ROS_DOMAIN_ID; `nacelle doctor net` lists them"));
}

TEST_F(Mirror, counts_readers_and_writers_of_other_participants) {
  auto writer = here.writer("/counted");
  {
    auto one = there.reader("/counted");
    auto two = there.reader("/counted", QoS(1).best_effort());
    ASSERT_TRUE(until([&] { return writer->reader_count() == 2 && one->writer_count() == 1; }));
    EXPECT_EQ(writer->status().matched, 2U);
    EXPECT_EQ(one->status().matched_total, 1U);
  }
  EXPECT_TRUE(until([&] { return writer->reader_count() == 0; }));
  EXPECT_EQ(writer->status().matched_total, 2U);
  auto three = there.reader("/counted");
  ASSERT_TRUE(until([&] { return three->writer_count() == 1; }));
  writer.reset();
  EXPECT_TRUE(until([&] { return three->writer_count() == 0; }));
}

TEST_F(Mirror, its_end_takes_its_ends_from_the_network) {
  auto writer = here.writer("/ended");
  auto reader = there.reader("/ended");
  ASSERT_TRUE(joined(*writer, *reader));
  there.mirror.reset();
  EXPECT_EQ(reader->writer_count(), 0U);
  EXPECT_TRUE(until([&] { return writer->reader_count() == 0; }));
}

TEST_F(Mirror, shows_its_nodes_with_their_ends_as_ros_does) {
  auto writer = here.writer("/chatter");
  auto reader = here.reader("/commands");
  std::optional<transport_dds::RemoteNodeInfo> node;
  ASSERT_TRUE(until([&] {
    there.mirror->look([&](const transport_dds::RemoteGraph& graph) { node = graph.node("/", "talker"); });
    return node && node->publishers.contains("/chatter") && node->subscriptions.contains("/commands");
  }));
  EXPECT_THAT(node->publishers.at("/chatter"), ElementsAre("std_msgs/msg/String"));
  there.mirror->look([&](const transport_dds::RemoteGraph& graph) {
    const auto ends = graph.ends_of_topic("/chatter");
    ASSERT_EQ(ends.size(), 1U);
    EXPECT_EQ(ends[0].user_data.type_hash, test::String::message_type().hash);
    EXPECT_EQ(ends[0].qos.depth(), 10U);
  });
  writer.reset();
  reader.reset();
  EXPECT_TRUE(until([&] {
    bool gone = false;
    there.mirror->look([&](const transport_dds::RemoteGraph& graph) { gone = graph.nodes().empty(); });
    return gone;
  })) << "a node without ends";
}

TEST_F(Mirror, makes_one_snapshot_of_many_changes) {
  const auto before = here.stats().snapshots;
  std::vector<std::unique_ptr<Writer>> many;
  for (int i = 0; i < 100; ++i) many.push_back(here.writer("/many_" + std::to_string(i)));
  ASSERT_TRUE(until([&] { return here.stats().writers == 100; }));
  EXPECT_LT(here.stats().snapshots - before, 100U);
}

// Voluntary context switches of the threads of that name.
std::uint64_t sleeps_of_threads(const std::string& name) {
  std::uint64_t count = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream comm(task.path() / "comm"), status(task.path() / "status");
    std::string line;
    if (!std::getline(comm, line) || !line.starts_with(name)) continue;
    const std::string key = "voluntary_ctxt_switches:";
    while (std::getline(status, line)) {
      if (line.starts_with(key)) count += std::stoull(line.substr(key.size()));
    }
  }
  return count;
}

TEST_F(Mirror, sleeps_without_a_remote_reader) {
  there.mirror.reset();
  auto writer = here.writer("/lonely");
  auto local = here.reader("/lonely");
  const auto rests = [&, last = std::uint64_t{0}]() mutable {
    const std::uint64_t now = sleeps_of_threads("network");
    return std::exchange(last, now) == now && here.stats().snapshots != 0;
  };
  ASSERT_TRUE(until([&] { return here.stats().writers + here.stats().readers == 2; }));
  ASSERT_TRUE(until(rests));
  // A wake-up by something that is not the messages would be one, not one for each.
  const std::uint64_t before = sleeps_of_threads("network");
  for (int i = 0; i < 1000; ++i) say(*writer, "x");
  EXPECT_LT(sleeps_of_threads("network") - before, 10U);
  EXPECT_EQ(here.stats().encoded + here.stats().taps, 0U);
}

TEST_F(Mirror, survives_ends_that_come_and_go_under_traffic) {
  std::atomic<bool> stop{false};
  std::thread talker([&] {
    int n = 0;
    const auto talk = [&](Writer& writer, int count) {
      for (int i = 0; i < count && !stop; ++i) {
        say(writer, std::to_string(++n));
        std::this_thread::yield();
      }
    };
    for (int made = 0; !stop; ++made) {
      auto writer = here.writer("/busy", QoS(5));
      talk(*writer, 200);
      // Most have ended before the network knows of them, above all on a busy machine; some wait until they are heard.
      while (made % 20 == 0 && !stop && writer->reader_count() == 0) talk(*writer, 1);
      talk(*writer, 20);
    }
  });
  std::size_t heard = 0;
  for (int round = 0; round < 30; ++round) {
    auto one = there.reader("/busy", QoS(5));
    auto two = there.reader("/busy", QoS(5), Taking::Own);
    if (round % 10 == 0) {
      heard += hear(there.bell, *one, 1).size();
      heard += hear(there.bell, *two, 1).size();
    }
  }
  stop = true;
  talker.join();
  EXPECT_GE(heard, 6U);
  EXPECT_EQ(there.stats().broken, 0U);
  EXPECT_TRUE(until([&] {
    const MirrorStats a = here.stats(), b = there.stats();
    return a.writers + a.readers + a.taps + a.stand_ins + b.writers + b.readers + b.taps + b.stand_ins == 0;
  }));
}

}  // namespace
}  // namespace nacelle
