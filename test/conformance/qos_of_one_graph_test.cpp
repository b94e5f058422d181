// SPDX-License-Identifier: Apache-2.0
// What a broker promises of its own streams, in one process or two. On a network it is for DDS, by a clock of its own, and no reader
// holds up a publisher (ADR 0012): see mirrored_laws_test.cpp for the laws there.
#include <thread>

#include "qos_laws.hpp"

namespace nacelle {
namespace {

template <typename T>
class QosOfOneGraph : public QosContract<T> {};
TYPED_TEST_SUITE(QosOfOneGraph, EveryTransport);

TYPED_TEST(QosOfOneGraph, a_late_joiner_gets_no_expired_history) {
  auto writer = this->writer(QoS(10).transient_local().lifespan(50ms));
  this->send(*writer, "old");
  this->clock.advance(40ms);
  this->send(*writer, "younger");
  this->clock.advance(20ms);
  auto late = this->reader(QoS(10).transient_local());
  EXPECT_EQ(this->receive(*late), typename TestFixture::Texts{"younger"});
  this->pass(1s);
  auto later = this->reader(QoS(10).transient_local());
  EXPECT_EQ(this->receive(*later), typename TestFixture::Texts{});
}

TYPED_TEST(QosOfOneGraph, manual_liveliness_is_lost_after_the_lease_and_comes_back_with_a_message_or_an_assertion) {
  Told lost, changed;
  const QoS manual = QoS(10).liveliness(Liveliness::ManualByTopic).liveliness_lease_duration(200ms);
  auto writer = this->writer(manual, &lost);
  auto reader = this->reader(manual, &changed);
  EXPECT_EQ(reader->status().alive, 1U);
  const MonotonicTime due = this->pass(200ms);
  EXPECT_EQ(due, this->clock.now() + 1ns);
  EXPECT_EQ(reader->status().alive, 1U);
  lost.times = changed.times = 0;
  EXPECT_EQ(this->pass(1ns), kNeverExpires);
  EXPECT_EQ(writer->status().liveliness_lost, 1U);
  EXPECT_EQ(reader->status().alive, 0U);
  EXPECT_EQ(reader->status().not_alive, 1U);
  EXPECT_EQ(lost.times, 1);
  EXPECT_EQ(changed.times, 1);
  this->pass(1s);
  EXPECT_EQ(writer->status().liveliness_lost, 1U) << "it is lost once";

  this->send(*writer, "here");
  EXPECT_EQ(reader->status().alive, 1U);
  EXPECT_EQ(changed.times, 2);
  this->pass(150ms);
  writer->assert_liveliness();
  this->pass(150ms);
  EXPECT_EQ(writer->status().liveliness_lost, 1U);
  this->pass(51ms);
  EXPECT_EQ(writer->status().liveliness_lost, 2U);
  writer->assert_liveliness();
  EXPECT_EQ(reader->status().alive, 1U);
  this->clock.advance(201ms);
  this->send(*writer, "late");
  EXPECT_EQ(writer->status().liveliness_lost, 3U) << "the lease ran out before anything looked at it";
  EXPECT_EQ(reader->status().alive, 1U);
  this->clock.advance(201ms);
  writer->assert_liveliness();
  EXPECT_EQ(writer->status().liveliness_lost, 4U);
  writer.reset();
  EXPECT_EQ(reader->status().alive + reader->status().not_alive, 0U);
}

TYPED_TEST(QosOfOneGraph, a_reliable_writer_waits_for_room_as_long_as_it_may) {
  auto reader = this->reader(QoS(KeepAll{}).max_samples(1));
  auto patient = this->writer(QoS(10).max_blocking_time(60s));
  // Many rounds, and in each a little longer until room is made: in most of them the sender has begun to wait by then.
  for (int round = 0; round < 20; ++round) {
    this->send(*patient, "a");
    PublishResult result{};
    std::atomic<bool> sending{false}, done{false};
    std::thread sender([&] {
      sending = true;
      result = this->send(*patient, "b");
      done = true;
    });
    while (!sending) std::this_thread::yield();
    for (int i = 0; i < 4 * round; ++i) std::this_thread::yield();
    typename TestFixture::Texts all;
    while (!done || reader->has_waiting()) {
      for (auto& text : this->receive(*reader)) all.push_back(text);
      std::this_thread::yield();
    }
    sender.join();
    ASSERT_EQ(all, (typename TestFixture::Texts{"a", "b"})) << round;
    ASSERT_EQ(result, PublishResult::Published) << round;
  }
  EXPECT_EQ(reader->counters().full, 0U);
}

TYPED_TEST(QosOfOneGraph, waiting_for_room_ends) {
  auto reader = this->reader(QoS(KeepAll{}).max_samples(1));
  auto writer = this->writer(QoS(10).max_blocking_time(1ns));
  this->send(*writer, "a");
  std::atomic<bool> done{false};
  std::thread sender([&] {
    EXPECT_EQ(this->send(*writer, "b"), PublishResult::WouldBlock);
    done = true;
  });
  while (!done) {
    this->clock.advance(1ms);
    std::this_thread::yield();
  }
  sender.join();
}

}  // namespace
}  // namespace nacelle
