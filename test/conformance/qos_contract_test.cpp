// SPDX-License-Identifier: Apache-2.0
// Deadline, lifespan, liveliness, waiting for room, and their statuses. Time is simulated.
#include <std_msgs/msg/header.hpp>
#include <thread>

#include "qos_laws.hpp"

namespace nacelle {
namespace {

TYPED_TEST_SUITE(QosContract, EveryTransport);

TYPED_TEST(QosContract, a_deadline_is_missed_once_for_each_whole_period_and_by_both_sides) {
  Told offered, requested;
  auto writer = this->writer(QoS(10).deadline(100ms), &offered);
  auto reader = this->reader(QoS(10).deadline(100ms), &requested);
  EXPECT_EQ(this->pass(1s), kNeverExpires) << "the first message starts the clock";
  EXPECT_EQ(writer->status().deadline_missed, 0U);
  offered.times = requested.times = 0;

  this->send(*writer, "a");
  const MonotonicTime due = this->pass(100ms);
  EXPECT_EQ(due, this->clock.now() + 1ns) << "exactly one period is kept";
  EXPECT_EQ(offered.times + requested.times, 0);
  this->pass(1ns);
  EXPECT_EQ(writer->status().deadline_missed, 1U);
  EXPECT_EQ(reader->status().deadline_missed, 1U);
  EXPECT_EQ(offered.times, 1);
  EXPECT_EQ(requested.times, 1);
  this->pass(1ms);
  EXPECT_EQ(reader->status().deadline_missed, 1U) << "the same period is not counted twice";
  this->pass(250ms);
  EXPECT_EQ(writer->status().deadline_missed, 3U);
  EXPECT_EQ(reader->status().deadline_missed, 3U);
}

TYPED_TEST(QosContract, a_late_message_counts_unchecked_missed_periods) {
  auto writer = this->writer(QoS(10).deadline(100ms));
  auto reader = this->reader(QoS(10).deadline(100ms));
  this->send(*writer, "a");
  this->clock.advance(350ms);
  this->send(*writer, "b");
  EXPECT_EQ(writer->status().deadline_missed, 3U);
  EXPECT_EQ(reader->status().deadline_missed, 3U);
  for (int i = 0; i < 5; ++i) {
    this->clock.advance(100ms);
    this->send(*writer, "on time");
  }
  EXPECT_EQ(reader->status().deadline_missed, 3U);
}

TYPED_TEST(QosContract, a_reader_counts_its_own_deadline_over_all_writers) {
  auto one = this->writer(QoS(10).deadline(100ms));
  auto two = this->writer(QoS(10).deadline(100ms));
  auto reader = this->reader(QoS(10).deadline(200ms));
  this->send(*one, "a");
  this->clock.advance(150ms);
  this->send(*two, "b");
  this->clock.advance(150ms);
  this->send(*one, "c");
  EXPECT_EQ(reader->status().deadline_missed, 0U);
  EXPECT_EQ(one->status().deadline_missed, 2U);
  EXPECT_EQ(two->status().deadline_missed, 0U);
}

TYPED_TEST(QosContract, a_closed_gate_stops_the_deadline) {
  std::atomic<bool> gate{true};
  EndpointSpec spec = this->at("/writer", QoS(10).deadline(100ms));
  spec.gate = &gate;
  auto writer = this->transport.create_writer(spec);
  auto reader = this->reader(QoS(10).deadline(100ms));
  this->send(*writer, "a");
  gate = false;
  reader->set_enabled(false);
  EXPECT_EQ(this->pass(1s), kNeverExpires);
  EXPECT_EQ(writer->status().deadline_missed, 0U);
  EXPECT_EQ(reader->status().deadline_missed, 0U);
}

TYPED_TEST(QosContract, a_message_older_than_its_lifespan_is_not_delivered_and_counted) {
  Told told;
  auto writer = this->writer(QoS(10).lifespan(50ms));
  auto reader = this->reader(QoS(10), &told);
  this->send(*writer, "old");
  this->clock.advance(30ms);
  this->send(*writer, "younger");
  this->clock.advance(20ms + 1ns);
  told.times = 0;
  EXPECT_EQ(this->receive(*reader), typename TestFixture::Texts{"younger"});
  EXPECT_EQ(reader->counters().expired, 1U);
  EXPECT_EQ(reader->status().lost, 1U);
  EXPECT_EQ(told.times, 1);
  this->send(*writer, "last");
  this->clock.advance(50ms);
  EXPECT_EQ(this->receive(*reader), typename TestFixture::Texts{"last"}) << "its last nanosecond still counts";
}

TYPED_TEST(QosContract, an_expired_message_makes_room_in_a_full_keep_all_reader) {
  auto writer = this->writer(QoS(10).lifespan(50ms));
  auto reader = this->reader(QoS(KeepAll{}).max_samples(1));
  EXPECT_EQ(this->send(*writer, "old"), PublishResult::Published);
  EXPECT_EQ(this->send(*writer, "no room"), kHoldsUp<TypeParam> ? PublishResult::WouldBlock : PublishResult::Published);
  this->clock.advance(51ms);
  EXPECT_EQ(this->send(*writer, "new"), PublishResult::Published);
  EXPECT_EQ(this->receive(*reader), typename TestFixture::Texts{"new"});
}

TYPED_TEST(QosContract, automatic_liveliness_lives_as_long_as_the_writer) {
  const QoS automatic = QoS(10).liveliness(Liveliness::Automatic).liveliness_lease_duration(200ms);
  auto writer = this->writer(automatic);
  auto reader = this->reader(automatic);
  this->pass(10s);
  EXPECT_EQ(reader->status().alive, 1U);
  EXPECT_EQ(writer->status().liveliness_lost, 0U);
}

TYPED_TEST(QosContract, reports_an_incompatible_pair_to_both_with_names_values_and_the_change) {
  Told offering, requesting;
  auto writer = this->writer(QoS(10).best_effort(), &offering);
  auto reader = this->reader(QoS(10).reliable(), &requesting);
  for (const EndpointStatus& status : {writer->status(), reader->status()}) {
    EXPECT_EQ(status.incompatible_qos, 1U);
    EXPECT_EQ(status.matched_total, 0U);
    EXPECT_EQ(status.last_policy, "reliability");
    for (const char* part : {"/writer", "/reader", "best_effort", "reliable"})
      EXPECT_NE(status.last_clash.find(part), std::string::npos) << part << " in: " << status.last_clash;
  }
  EXPECT_EQ(offering.times, 1);
  EXPECT_EQ(requesting.times, 1);
}

TYPED_TEST(QosContract, a_second_reader_gets_messages_that_the_first_cannot_and_none_twice) {
  using Words = std::vector<std::string>;
  const QoS latched = QoS(KeepAll{}).reliable().transient_local();
  auto first = this->transport.create_reader(this->at("/base", latched), Taking::Share, nullptr);
  EndpointSpec spec = this->at("/base", QoS(10).best_effort());
  spec.unless_offered = latched;
  auto second = this->transport.create_reader(spec, Taking::Share, nullptr);
  auto lasting = this->writer(latched), passing = this->writer(QoS(10)), careless = this->writer(QoS(10).best_effort());
  EXPECT_EQ(first->writer_count(), 1U);
  EXPECT_EQ(second->writer_count(), 2U);
  EXPECT_EQ(second->status().incompatible_qos, 0U);
  this->send(*lasting, "latched");
  this->send(*passing, "volatile");
  this->send(*careless, "best effort");
  EXPECT_EQ(this->receive(*first), Words{"latched"});
  EXPECT_EQ(this->receive(*second), (Words{"volatile", "best effort"}));
}

TYPED_TEST(QosContract, counts_and_reports_a_match_and_its_end) {
  Told told;
  auto writer = this->writer(QoS(10), &told);
  auto reader = this->reader(QoS(10));
  EXPECT_EQ(writer->status().matched, 1U);
  EXPECT_EQ(reader->status().matched_total, 1U);
  EXPECT_EQ(told.times, 1);
  reader.reset();
  EXPECT_EQ(writer->status().matched, 0U);
  EXPECT_EQ(writer->status().matched_total, 1U);
  EXPECT_EQ(told.times, 2);
}

TYPED_TEST(QosContract, reports_another_type_once_but_not_to_a_node_that_reads_both) {
  auto writer = this->writer(QoS(10));
  EndpointSpec other = this->at("/reader", QoS(10));
  other.type = &std_msgs::msg::Header::message_type();
  auto reader = this->transport.create_reader(other, Taking::Share, nullptr);
  other.node = "/base";
  auto of_both = this->transport.create_reader(other, Taking::Share, nullptr);
  auto fitting = this->transport.create_reader(this->at("/base", QoS(10)), Taking::Share, nullptr);
  this->pass(1ms);
  this->pass(1ms);
  EXPECT_EQ(writer->status().incompatible_type, 1U);
  EXPECT_EQ(reader->status().incompatible_type, 1U);
  EXPECT_EQ(reader->status().last_policy, "type");
  EXPECT_EQ(of_both->status().incompatible_type, 0U);
}

}  // namespace
}  // namespace nacelle
