// SPDX-License-Identifier: Apache-2.0
// Incompatible endpoints of two graphs that only the network joins, and broken messages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <std_msgs/msg/header.hpp>

#include "mirrored.hpp"

namespace nacelle {
namespace {

using test::hear;
using test::Mirror;
using test::say;
using test::Texts;
using ::testing::AllOf;
using ::testing::HasSubstr;

struct Misfit {
  const char* policy;
  QoS offered, requested;
};
void PrintTo(const Misfit& misfit, std::ostream* out) { *out << misfit.policy; }

class MirrorMisfit : public Mirror, public ::testing::WithParamInterface<Misfit> {};

TEST_P(MirrorMisfit, of_qos_is_reported_on_both_sides_with_the_policy) {
  auto writer = here.writer("/misfit", GetParam().offered);
  auto reader = there.reader("/misfit", GetParam().requested);
  ASSERT_TRUE(until([&] { return writer->status().incompatible_qos == 1 && reader->status().incompatible_qos == 1; }));
  EXPECT_EQ(writer->status().last_policy, GetParam().policy);
  EXPECT_EQ(reader->status().last_policy, GetParam().policy);
  for (const std::string& text : {writer->status().last_clash, reader->status().last_clash})
    EXPECT_THAT(text, AllOf(HasSubstr("/misfit"), HasSubstr("/talker"), HasSubstr("/listener")));
  EXPECT_EQ(writer->reader_count() + reader->writer_count(), 0U);
}

INSTANTIATE_TEST_SUITE_P(EveryPolicy, MirrorMisfit,
                         ::testing::Values(Misfit{"reliability", QoS(1).best_effort(), QoS(1)},
                                           Misfit{"durability", QoS(1), QoS(1).transient_local()},
                                           Misfit{"deadline", QoS(1), QoS(1).deadline(100ms)},
                                           Misfit{"liveliness", QoS(1), QoS(1).liveliness(Liveliness::ManualByTopic)},
                                           Misfit{"liveliness_lease_duration", QoS(1),
                                                  QoS(1).liveliness_lease_duration(1s)}),
                         [](const auto& one) { return one.param.policy; });

// The endpoint belongs to no node. The mirror waits for its name, but only once, even if no local reader has its topic at that time.
TEST_F(Mirror, tells_a_later_reader_at_once_of_a_misfit_that_is_known) {
  auto reader = there.reader("/nameless"), fitting = there.reader("/fitting"), later = there.reader("/later");
  test::Told told;
  const auto participant = test::make_participant();
  const auto made_raw = [&](const char* topic, const QoS& qos) {
    return participant->create_writer(test::string_topic(topic, qos), &told);
  };
  auto raw = made_raw("nameless", QoS(1).best_effort()), behind_it = made_raw("fitting", QoS(1));
  ASSERT_TRUE(raw && behind_it);
  ASSERT_TRUE(until([&] { return fitting->writer_count() == 1; }));
  reader.reset();
  auto raw_later = made_raw("later", QoS(1).best_effort());
  ASSERT_TRUE(until([&] { return later->status().incompatible_qos == 1; }));
  const SystemClock clock;
  const MonotonicTime made = clock.now();
  reader = there.reader("/nameless");
  ASSERT_TRUE(until([&] { return reader->status().incompatible_qos == 1; }));
  EXPECT_LT(clock.now() - made, 900ms) << "the mirror waits one second for a name";
}

TEST_F(Mirror, tells_once_of_a_viewer_that_asks_for_more_and_does_not_count_it) {
  auto writer = here.writer("/scan", QoS(5).best_effort());
  auto viewer = there.reader("/scan", QoS(5).reliable());
  ASSERT_TRUE(until([&] { return here.problems.lock()->size() == 1; }));
  EXPECT_THAT(here.problems.lock()->front(),
              AllOf(HasSubstr("/scan"), HasSubstr("/talker publishes with reliability best_effort"),
                    HasSubstr("/listener asks for reliable: it gets nothing from it"), HasSubstr("best_effort")));
  const auto readers = [&] {
    std::vector<runtime::StreamReport> rows;
    here.broker.report(rows);
    return std::ranges::find(rows, "/scan", &runtime::StreamReport::name)->readers;
  };
  EXPECT_EQ(readers(), 0U);
  auto fitting = there.reader("/scan", QoS(5).best_effort());
  EXPECT_TRUE(until([&] { return readers() == 1 && writer->reader_count() == 1; }));
  // A writer that comes later is another pair of one that is known; the same node is reported once.
  auto later = here.writer("/scan", QoS(5).best_effort());
  ASSERT_TRUE(until([&] { return later->status().matched == 1; }));
  EXPECT_EQ(here.problems.lock()->size(), 1U);
}

TEST_F(Mirror, says_when_it_reports_no_more_misfits) {
  constexpr std::size_t kReported = 256;
  std::vector<std::unique_ptr<Writer>> writers;
  std::vector<std::unique_ptr<Reader>> viewers;
  for (std::size_t i = 0; i < kReported + 2; ++i) {
    const std::string topic = "/scan_" + std::to_string(i);
    writers.push_back(here.writer(topic, QoS(5).best_effort()));
    viewers.push_back(there.reader(topic, QoS(5).reliable()));
  }
  ASSERT_TRUE(until([&] { return here.problems.lock()->size() == kReported + 1; }));
  EXPECT_THAT(here.problems.lock()->back(), AllOf(HasSubstr("256 problems"), HasSubstr("restart the container")));
  writers.push_back(here.writer("/late", QoS(5).best_effort()));
  viewers.push_back(there.reader("/late", QoS(5).reliable()));
  ASSERT_TRUE(until([&] { return viewers.back()->status().incompatible_qos == 1; }));
  EXPECT_EQ(here.problems.lock()->size(), kReported + 1);
}

TEST_F(Mirror, does_not_report_a_viewer_that_reads_the_publisher_by_another_subscription) {
  auto writer = here.writer("/stop", QoS(5));
  auto latched = there.reader("/stop", QoS(5).transient_local());
  EndpointSpec spec = there.spec("/stop", QoS(5).best_effort());
  spec.unless_offered = QoS(5).transient_local();
  auto other = there.broker.create_reader(spec, Taking::Share, &there.bell);
  auto unserved = there.reader("/told", QoS(5).transient_local());
  auto marker = here.writer("/told", QoS(5));
  ASSERT_TRUE(until([&] { return !here.problems.lock()->empty() && writer->reader_count() == 1; }));
  EXPECT_THAT(*here.problems.lock(), ::testing::Each(HasSubstr("/told")));
  say(*writer, "stop");
  EXPECT_EQ(hear(there.bell, *other, 1), Texts{"stop"});
}

TEST_F(Mirror, tells_once_of_two_types_under_one_name) {
  EndpointSpec other = here.spec("/typed");
  other.type = &std_msgs::msg::Header::message_type();
  auto writer = here.broker.create_writer(other);
  auto reader = there.reader("/typed");
  ASSERT_TRUE(there.bell.until([&] { return !there.problems.lock()->empty(); }));
  ASSERT_TRUE(here.bell.until([&] { return !here.problems.lock()->empty(); }));
  auto again = there.reader("/typed");
  auto fits = here.writer("/typed");
  ASSERT_TRUE(until([&] { return fits->reader_count() == 2 && again->writer_count() == 1; }));
  const Texts told = *there.problems.lock();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_THAT(told[0], HasSubstr("/typed"));
  EXPECT_THAT(told[0], HasSubstr("std_msgs/msg/Header"));
  EXPECT_THAT(told[0], HasSubstr("std_msgs/msg/String"));
  EXPECT_EQ(writer->reader_count(), 0U);
}

TEST_F(Mirror, counts_bytes_that_are_no_message_and_goes_on) {
  const QoS all{KeepAll{}};
  auto reader = there.reader("/hostile", all);
  test::Told told;
  const auto participant = test::make_participant();
  auto raw = participant->create_writer(test::string_topic("hostile", all), &told);
  ASSERT_TRUE(raw);
  ASSERT_TRUE(until([&] { return reader->writer_count() == 1 && (*raw)->matched_count() == 1; }));
  const unsigned seed = 5;
  std::mt19937 random{seed};
  constexpr unsigned kMessages = 300;
  for (unsigned i = 0; i < kMessages; ++i) {
    Bytes bytes(4 + random() % 200);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    bytes[0] = 0;
    bytes[1] = 1;
    if (bytes.size() > 7) bytes[7] |= 0x80;  // a length that no text of these bytes has
    ASSERT_EQ(test::say_bytes(**raw, bytes), transport_dds::Writer::Sent::Yes);
  }
  ASSERT_EQ(test::say(**raw, "sane"), transport_dds::Writer::Sent::Yes);
  EXPECT_EQ(hear(there.bell, *reader, 1), Texts{"sane"});
  EXPECT_EQ(there.stats().broken, kMessages) << "seed " << seed;
  EXPECT_EQ(there.problems.lock()->size(), 1U) << "reported once";
}

TEST_F(Mirror, does_not_listen_to_another_definition_of_a_type) {
  auto reader = there.reader("/defined");
  test::Told told;
  const auto participant = test::make_participant();
  auto options = test::string_topic("defined");
  const std::string data = "typehash=RIHS01_" + std::string(64, '0') + ";";
  const ByteView bytes = as_bytes(data);
  options.user_data.assign(bytes.begin(), bytes.end());
  auto raw = participant->create_writer(options, &told);
  ASSERT_TRUE(raw);
  ASSERT_TRUE(told.until([&] { return (*raw)->matched_count() == 1; }));
  ASSERT_TRUE(there.bell.until([&] { return !there.problems.lock()->empty(); }));
  ASSERT_EQ(test::say(**raw, "other"), transport_dds::Writer::Sent::Yes);
  EXPECT_TRUE(until([&] { return there.stats().stray == 1; }));
  EXPECT_EQ(reader->writer_count(), 0U);
}

TEST_F(Mirror, tells_of_a_remote_writers_missed_deadline) {
  const QoS qos = QoS(1).deadline(50ms);
  auto reader = there.reader("/deadline", qos);
  auto writer = here.writer("/deadline", qos);
  ASSERT_TRUE(joined(*writer, *reader));
  say(*writer, "the clock starts");
  EXPECT_TRUE(there.bell.until([&] { return reader->status().deadline_missed != 0; }));
}

TEST_F(Mirror, tells_of_a_remote_writers_lost_liveliness_and_of_its_return) {
  const QoS qos = QoS(1).liveliness(Liveliness::ManualByTopic).liveliness_lease_duration(300ms);
  auto reader = there.reader("/life", qos);
  auto writer = here.writer("/life", qos);
  ASSERT_TRUE(joined(*writer, *reader));
  say(*writer, "alive");
  ASSERT_TRUE(there.bell.until([&] { return reader->status().alive == 1; }));
  ASSERT_TRUE(there.bell.until([&] { return reader->status().not_alive == 1; }));
  say(*writer, "again");
  EXPECT_TRUE(there.bell.until([&] { return reader->status().alive == 1; }));
}

}  // namespace
}  // namespace nacelle
