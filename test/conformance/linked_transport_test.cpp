// SPDX-License-Identifier: Apache-2.0
// What holds between processes in place of the laws that only hold within one.
#include "transport_laws.hpp"

namespace nacelle {
namespace {

using LinkedTransport = TransportLaws<test::LinkedBrokers>;

runtime::StreamReport stream_of(const runtime::Broker& broker) {
  std::vector<runtime::StreamReport> streams;
  broker.report(streams);
  return streams.empty() ? runtime::StreamReport{} : streams.front();
}

TEST_F(LinkedTransport, what_crosses_to_another_process_is_counted_as_copied_once_on_each_side) {
  auto writer = transport.create_writer(spec(10));
  auto one = transport.create_reader(spec(10), Taking::Share, nullptr);
  auto two = transport.create_reader(spec(10), Taking::Share, nullptr);
  for (const char* text : {"abc", "def"}) send(*writer, text);
  EXPECT_EQ(receive(*one), (Texts{"abc", "def"}));
  EXPECT_EQ(receive(*two), (Texts{"abc", "def"}));
  for (const auto* broker : {&transport.writers(), &transport.readers()}) {
    EXPECT_EQ(stream_of(*broker).copies, 2U) << "not once for each reader";
    EXPECT_EQ(stream_of(*broker).bytes_copied, 2 * (4 + 4 + 4U));
  }
  EXPECT_EQ(transport.writers_link().stats().sent, 2U);
}

TEST_F(LinkedTransport, an_adopted_message_arrives_and_goes_home) {
  auto writer = transport.create_writer(spec(10));
  auto reader = transport.create_reader(spec(10), Taking::Share, nullptr);
  auto message = std::make_unique<String>();
  message->data = "adopted";
  writer->publish(*writer->adopt(message.release()));
  EXPECT_EQ(receive(*reader), Texts{"adopted"});
}

TEST_F(LinkedTransport, exactly_max_samples_are_outstanding_until_the_reader_takes_one) {
  auto reader = transport.create_reader(spec(QoS(KeepAll{}).max_samples(3)), Taking::Share, nullptr);
  auto writer = transport.create_writer(spec(QoS(10).reliable()));
  for (int round = 0; round < 5; ++round) {
    int accepted = 0;
    while (send(*writer, "x") == PublishResult::Published) ++accepted;
    EXPECT_EQ(accepted, round == 0 ? 3 : 1);
    drop_reference(*reader->take());
  }
  EXPECT_EQ(reader->counters().full, 5U);
  EXPECT_EQ(reader->counters().delivered, 5U);
}

TEST_F(LinkedTransport, a_closed_gate_frees_what_a_keep_all_reader_had_outstanding) {
  auto reader = transport.create_reader(spec(QoS(KeepAll{}).max_samples(2)), Taking::Share, nullptr);
  auto writer = transport.create_writer(spec(QoS(10).reliable()));
  for (int i = 0; i < 2; ++i) EXPECT_EQ(send(*writer, "x"), PublishResult::Published);
  reader->set_enabled(false);
  reader->set_enabled(true);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(send(*writer, "y"), PublishResult::Published);
  EXPECT_EQ(send(*writer, "y"), PublishResult::WouldBlock);
  EXPECT_EQ(receive(*reader), (Texts{"y", "y"}));
}

TEST_F(LinkedTransport, the_receive_stamp_is_the_readers) {
  auto writer = transport.create_writer(spec(10));
  auto reader = transport.create_reader(spec(10), Taking::Share, nullptr);
  send(*writer, "x");
  Block* const block = reader->take();
  ASSERT_NE(block, nullptr);
  EXPECT_EQ(block->info.received_time, clock.now());
  EXPECT_EQ(block->info.writer_id, writer->id());
  drop_reference(*block);
}

TEST_F(LinkedTransport, a_history_that_was_replayed_to_one_late_joiner_reaches_the_next_one_once) {
  auto writer = transport.create_writer(spec(QoS(5).transient_local()));
  send(*writer, "a");
  auto one = transport.create_reader(spec(QoS(5).transient_local()), Taking::Share, nullptr);
  auto live_only = transport.create_reader(spec(QoS(5)), Taking::Share, nullptr);
  auto two = transport.create_reader(spec(QoS(5).transient_local()), Taking::Own, nullptr);
  send(*writer, "b");
  EXPECT_EQ(receive(*one), (Texts{"a", "b"}));
  EXPECT_EQ(receive(*two), (Texts{"a", "b"}));
  EXPECT_EQ(receive(*live_only), Texts{"b"});
}

}  // namespace
}  // namespace nacelle
