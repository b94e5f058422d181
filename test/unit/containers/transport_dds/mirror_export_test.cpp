// SPDX-License-Identifier: Apache-2.0
// What a list of exports lets out of a graph.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mirrored.hpp"

namespace nacelle {
namespace {

using test::hear;
using test::say;
using test::Texts;
using transport_dds::ExportRule;

class MirrorExport : public ::testing::Test {
 public:
  void start(std::vector<ExportRule> rules) {
    here.emplace("talker", std::move(rules));
    there.emplace("listener");
  }
  template <typename F>
  [[nodiscard]] bool until(F holds) {
    return here->bell.until(holds);
  }
  [[nodiscard]] bool joined(const Writer& writer, const Reader& reader) {
    return until([&] { return writer.reader_count() == 1 && reader.writer_count() == 1; });
  }
  std::optional<test::MirroredBroker> here, there;
};

TEST_F(MirrorExport, shows_what_is_listed_and_hides_the_rest_both_ways) {
  start({{"/shown"}});
  auto shown = here->writer("/shown"), hidden = here->writer("/hidden");
  auto commands = here->reader("/commands");
  auto reads_shown = there->reader("/shown"), reads_hidden = there->reader("/hidden");
  auto commander = there->writer("/commands");
  ASSERT_TRUE(joined(*shown, *reads_shown));
  EXPECT_EQ(here->stats().hidden, 2U);
  EXPECT_EQ(here->stats().writers, 1U);
  // Earlier announcements have arrived by now: discovery delivers in order.
  auto late = here->writer("/shown");
  ASSERT_TRUE(until([&] { return reads_shown->writer_count() == 2; }));
  EXPECT_EQ(reads_hidden->writer_count(), 0U);
  EXPECT_EQ(commander->reader_count(), 0U);
  bool is_known = true;
  there->mirror->look([&](const transport_dds::RemoteGraph& graph) {
    is_known = !graph.ends_of_topic("/hidden").empty() || !graph.ends_of_topic("/commands").empty();
  });
  EXPECT_FALSE(is_known) << "not even its name is on the network";
  say(*hidden, "secret");
  say(*shown, "open");
  EXPECT_EQ(hear(there->bell, *reads_shown, 1), Texts{"open"});
  EXPECT_TRUE(until([&] { return here->stats().encoded == 1; }));  // counted once it is sent
  EXPECT_TRUE(hear(*reads_hidden).empty());
  hidden.reset();
  commands.reset();
  EXPECT_TRUE(until([&] { return here->stats().hidden == 0; }));
}

TEST_F(MirrorExport, thins_a_topic_to_its_rate_and_counts_what_it_keeps_back) {
  start({{"/thin", 0.001}});
  auto writer = here->writer("/thin");
  auto reader = there->reader("/thin");
  ASSERT_TRUE(joined(*writer, *reader));
  for (int i = 0; i < 5; ++i) say(*writer, std::to_string(i));
  EXPECT_EQ(hear(there->bell, *reader, 1), Texts{"0"});
  EXPECT_TRUE(until([&] { return here->stats().held_back == 4; }));
  EXPECT_EQ(here->stats().encoded, 1U);
}

TEST_F(MirrorExport, two_writers_of_a_topic_share_its_limit) {
  start({{"/thin", 0.001}});
  auto one = here->writer("/thin"), two = here->writer("/thin");
  auto reader = there->reader("/thin");
  ASSERT_TRUE(
      until([&] { return reader->writer_count() == 2 && one->reader_count() == 1 && two->reader_count() == 1; }));
  say(*one, "one");
  EXPECT_EQ(hear(there->bell, *reader, 1), Texts{"one"});
  say(*two, "two");
  EXPECT_TRUE(until([&] { return here->stats().held_back == 1; }));
}

TEST_F(MirrorExport, delays_the_newest_message_of_a_transient_local_writer_without_losing_it) {
  start({{"/latched", 20}});
  const QoS latched = QoS(1).transient_local();
  auto writer = here->writer("/latched", latched);
  auto reader = there->reader("/latched", latched);
  ASSERT_TRUE(joined(*writer, *reader));
  for (int i = 0; i < 40; ++i) say(*writer, std::to_string(i));
  Texts heard;
  EXPECT_TRUE(there->bell.until([&] {
    for (auto& text : hear(*reader)) heard.push_back(std::move(text));
    return !heard.empty() && heard.back() == "39";
  })) << ::testing::PrintToString(heard);
  EXPECT_EQ(here->stats().held_back, 0U);
}

TEST_F(MirrorExport, keeps_the_bytes_of_a_topic_within_their_limit) {
  start({{"/bytes", 0, 100}});
  auto writer = here->writer("/bytes");
  auto reader = there->reader("/bytes");
  ASSERT_TRUE(joined(*writer, *reader));
  say(*writer, std::string(10'000, 'x'));  // a hundred seconds' worth: goes, and the next does not
  say(*writer, "y");
  EXPECT_EQ(hear(there->bell, *reader, 1).size(), 1U);
  EXPECT_TRUE(until([&] { return here->stats().held_back == 1; }));
}

}  // namespace
}  // namespace nacelle
