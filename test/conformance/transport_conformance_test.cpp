// SPDX-License-Identifier: Apache-2.0
// What every Transport promises, written against its doc comment.
#include <std_msgs/msg/header.hpp>

#include "transport_laws.hpp"

namespace nacelle {
namespace {

TYPED_TEST_SUITE(TransportLaws, EveryTransport);

TYPED_TEST(TransportLaws, delivers_in_the_order_sent) {
  auto writer = this->transport.create_writer(this->spec(10));
  auto reader = this->transport.create_reader(this->spec(10), Taking::Share, nullptr);
  for (const char* text : {"a", "b", "c"}) this->send(*writer, text);
  EXPECT_EQ(this->receive(*reader), (typename TestFixture::Texts{"a", "b", "c"}));
}

TYPED_TEST(TransportLaws, keep_last_keeps_the_newest_and_counts_what_made_room) {
  for (const auto& qos : {QoS(2).reliable(), QoS(2).best_effort()}) {
    auto writer = this->transport.create_writer(this->spec(qos));
    auto reader = this->transport.create_reader(this->spec(qos), Taking::Share, nullptr);
    for (const char* text : {"a", "b", "c", "d", "e"}) EXPECT_EQ(this->send(*writer, text), PublishResult::Published);
    EXPECT_EQ(this->receive(*reader), (typename TestFixture::Texts{"d", "e"}));
    const auto counters = reader->counters();
    EXPECT_EQ(counters.received, 5U);
    EXPECT_EQ(counters.overwritten, 3U);
    EXPECT_EQ(counters.delivered, 2U);
  }
}

TYPED_TEST(TransportLaws, keep_all_refuses_when_it_is_full_and_notifies_a_reliable_writer) {
  auto reader =
      this->transport.create_reader(this->spec(QoS(KeepAll{}).best_effort().max_samples(3)), Taking::Share, nullptr);
  auto reliable = this->transport.create_writer(this->spec(QoS(10).reliable()));
  auto hasty = this->transport.create_writer(this->spec(QoS(10).best_effort()));
  for (const char* text : {"a", "b", "c"}) EXPECT_EQ(this->send(*reliable, text), PublishResult::Published);
  EXPECT_EQ(this->send(*reliable, "d"), kHoldsUp<TypeParam> ? PublishResult::WouldBlock : PublishResult::Published);
  EXPECT_EQ(this->send(*hasty, "e"), PublishResult::Published);
  EXPECT_EQ(this->receive(*reader), (typename TestFixture::Texts{"a", "b", "c"}));
  EXPECT_EQ(reader->counters().full, 2U);
  EXPECT_EQ(reliable->counters().would_block, kHoldsUp<TypeParam> ? 1U : 0U);
}

TYPED_TEST(TransportLaws, a_late_joiner_gets_the_history_that_both_sides_ask_for) {
  for (const bool offered : {false, true}) {
    for (const bool requested : {false, true}) {
      for (const std::size_t depth : {1U, 3U}) {
        const QoS offer = offered ? QoS(depth).transient_local() : QoS(depth);
        const QoS request = requested ? QoS(10).transient_local() : QoS(10);
        auto writer = this->transport.create_writer(this->spec(offer));
        for (const char* text : {"a", "b", "c", "d"}) this->send(*writer, text);
        auto late = this->transport.create_reader(this->spec(request), Taking::Share, nullptr);
        this->send(*writer, "live");
        typename TestFixture::Texts expected;
        if (offered && requested)
          expected = depth == 1 ? typename TestFixture::Texts{"d"} : typename TestFixture::Texts{"b", "c", "d"};
        if (offered || !requested) expected.push_back("live");  // volatile to transient_local is no match
        EXPECT_EQ(this->receive(*late), expected) << offered << requested << depth;
      }
    }
  }
}

TYPED_TEST(TransportLaws, an_incompatible_pair_exchanges_nothing) {
  auto writer = this->transport.create_writer(this->spec(QoS(10).best_effort()));
  auto picky = this->transport.create_reader(this->spec(QoS(10).reliable()), Taking::Share, nullptr);
  auto easy = this->transport.create_reader(this->spec(QoS(10).best_effort()), Taking::Share, nullptr);
  this->send(*writer, "a");
  EXPECT_EQ(this->receive(*picky), typename TestFixture::Texts{});
  EXPECT_EQ(this->receive(*easy), typename TestFixture::Texts{"a"});
  EXPECT_EQ(writer->reader_count(), 1U);
  EXPECT_EQ(picky->writer_count(), 0U);
}

TYPED_TEST(TransportLaws, another_type_on_the_same_name_is_another_stream) {
  auto writer = this->transport.create_writer(this->spec(10));
  auto other = this->transport.create_reader({"/chat", &std_msgs::msg::Header::message_type(), QoS(10), "/node"},
                                             Taking::Share, nullptr);
  this->send(*writer, "a");
  EXPECT_FALSE(other->has_waiting());
}

TYPED_TEST(TransportLaws, stamps_each_message_with_writer_sequence_and_time) {
  auto one = this->transport.create_writer(this->spec(10));
  auto two = this->transport.create_writer(this->spec(10));
  auto reader = this->transport.create_reader(this->spec(10), Taking::Share, nullptr);
  this->send(*one, "a");
  this->clock.advance(5ms);
  this->send(*two, "b");
  this->send(*one, "c");
  EXPECT_NE(one->id(), two->id());
  const std::uint64_t writers[] = {one->id(), two->id(), one->id()};
  const std::uint64_t sequences[] = {1, 1, 2};
  const MonotonicTime end = this->clock.now();
  for (int i = 0; i < 3; ++i) {
    Block* const block = reader->take();
    ASSERT_NE(block, nullptr);
    EXPECT_EQ(block->info.sequence, sequences[i]);
    if constexpr (kTellsInfo<TypeParam>) {
      EXPECT_EQ(block->info.writer_id, writers[i]);
      EXPECT_EQ(block->info.source_time, i == 0 ? end - 5ms : end);
    }
    drop_reference(*block);
  }
}

TYPED_TEST(TransportLaws, sharers_see_one_message_and_an_owner_has_its_own) {
  auto writer = this->transport.create_writer(this->spec(10));
  auto first = this->transport.create_reader(this->spec(10), Taking::Share, nullptr);
  auto second = this->transport.create_reader(this->spec(10), Taking::Share, nullptr);
  auto owner = this->transport.create_reader(this->spec(10), Taking::Own, nullptr);
  this->send(*writer, "a");
  Block* const a = first->take();
  Block* const b = second->take();
  Block* const mine = owner->take();
  ASSERT_TRUE(a != nullptr && b != nullptr && mine != nullptr);
  if constexpr (kTellsInfo<TypeParam>) { EXPECT_EQ(a->message, b->message); }
  EXPECT_NE(mine->message, a->message);
  EXPECT_EQ(mine->references.load(), 1U);
  static_cast<String*>(mine->message)->data = "changed";
  EXPECT_EQ(static_cast<String*>(a->message)->data, "a");
  for (Block* block : {a, b, mine}) drop_reference(*block);
}

TYPED_TEST(TransportLaws, a_closed_gate_lets_nothing_out_and_counts) {
  std::atomic<bool> gate{false};
  EndpointSpec spec = this->spec(10);
  spec.gate = &gate;
  auto writer = this->transport.create_writer(spec);
  auto reader = this->transport.create_reader(this->spec(10), Taking::Share, nullptr);
  EXPECT_EQ(this->send(*writer, "a"), PublishResult::Inactive);
  gate = true;
  EXPECT_EQ(this->send(*writer, "b"), PublishResult::Published);
  EXPECT_EQ(this->receive(*reader), typename TestFixture::Texts{"b"});
  EXPECT_EQ(writer->counters().inactive, 1U);
}

TYPED_TEST(TransportLaws, a_disabled_reader_drops_what_waits_and_what_comes) {
  auto writer = this->transport.create_writer(this->spec(10));
  auto reader = this->transport.create_reader(this->spec(10), Taking::Share, nullptr);
  this->send(*writer, "a");
  reader->set_enabled(false);
  this->send(*writer, "b");
  reader->set_enabled(true);
  this->send(*writer, "c");
  EXPECT_EQ(this->receive(*reader), typename TestFixture::Texts{"c"});
  EXPECT_EQ(reader->counters().inactive, 2U);
}

TYPED_TEST(TransportLaws, opening_a_gate_brings_the_history_that_was_missed_and_nothing_twice) {
  auto writer = this->transport.create_writer(this->spec(QoS(5).transient_local()));
  auto reader = this->transport.create_reader(this->spec(QoS(5).transient_local()), Taking::Share, nullptr);
  this->send(*writer, "a");
  EXPECT_EQ(this->receive(*reader), typename TestFixture::Texts{"a"});
  reader->set_enabled(false);
  this->send(*writer, "b");
  EXPECT_EQ(this->receive(*reader), typename TestFixture::Texts{});
  reader->set_enabled(true);
  EXPECT_EQ(this->receive(*reader), typename TestFixture::Texts{"b"});
}

TYPED_TEST(TransportLaws, a_reader_made_behind_a_closed_gate_gets_the_history_when_it_opens) {
  const std::atomic<bool> closed{false};
  EndpointSpec spec = this->spec(QoS(5).transient_local());
  auto writer = this->transport.create_writer(spec);
  this->send(*writer, "a");
  spec.gate = &closed;
  auto reader = this->transport.create_reader(spec, Taking::Share, nullptr);
  EXPECT_FALSE(reader->has_waiting());
  reader->set_enabled(true);
  EXPECT_EQ(this->receive(*reader), typename TestFixture::Texts{"a"});
}

TYPED_TEST(TransportLaws, tells_the_listener_of_each_arrival) {
  struct Count final : ReadyListener {
    void on_ready() noexcept override { ++n; }
    int n = 0;
  } count;
  auto writer = this->transport.create_writer(this->spec(10));
  {
    auto reader = this->transport.create_reader(this->spec(10), Taking::Share, &count);
    this->send(*writer, "a");
    EXPECT_EQ(count.n, 1);
  }
  this->send(*writer, "b");
  EXPECT_EQ(count.n, 1);
}

TYPED_TEST(TransportLaws, a_message_outlives_its_writer_and_its_reader) {
  auto writer = this->transport.create_writer(this->spec(10));
  auto reader = this->transport.create_reader(this->spec(10), Taking::Share, nullptr);
  this->send(*writer, "kept");
  Block* const block = reader->take();
  ASSERT_NE(block, nullptr);
  writer.reset();
  reader.reset();
  EXPECT_EQ(static_cast<const String*>(block->message)->data, "kept");
  drop_reference(*block);
}

TYPED_TEST(TransportLaws, one_shared_ptr_serves_all_readers_and_ends_last) {
  auto writer = this->transport.create_writer(this->spec(10));
  auto reader = this->transport.create_reader(this->spec(10), Taking::Share, nullptr);
  this->send(*writer, "shared");
  Block* const block = reader->take();
  ASSERT_NE(block, nullptr);
  std::shared_ptr<const void> one = share_block(*block);
  std::shared_ptr<const void> two = share_block(*block);
  drop_reference(*block);
  one.reset();
  EXPECT_EQ(static_cast<const String*>(two.get())->data, "shared");
}

}  // namespace
}  // namespace nacelle
