// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/broker.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <sensor_msgs/msg/image.hpp>
#include <std_msgs/msg/header.hpp>
#include <std_msgs/msg/string.hpp>
#include <thread>

#include "support/allocation_guard.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::runtime {
namespace {

using sensor_msgs::msg::Image;

EndpointSpec image_spec(const QoS& qos, const std::string& node) {
  return {"/image", &Image::message_type(), qos, node};
}

struct Fixture : ::testing::Test {
  test::ManualClock clock;
  Broker broker{clock};
  std::vector<StreamReport> report;
  const StreamReport& stream(const std::string& name) {
    broker.report(report);
    for (const auto& row : report) {
      if (row.name == name) return row;
    }
    static const StreamReport none;
    return none;
  }
};
using BrokerTest = Fixture;

TEST_F(BrokerTest, reports_a_late_reader_with_its_queue_and_losses) {
  auto writer = broker.create_writer(image_spec(QoS(10).deadline(100ms), "/camera"));
  auto slow = broker.create_reader(image_spec(QoS(3).deadline(100ms), "/slow"), Taking::Share, nullptr);
  auto closed = broker.create_reader(image_spec(QoS(5), "/closed"), Taking::Share, nullptr);
  auto tool = broker.create_reader(image_spec(QoS(5), ""), Taking::Share, nullptr);
  closed->set_enabled(false);
  for (int i = 0; i < 5; ++i) writer->publish(*writer->borrow());
  drop_reference(*slow->take());
  clock.advance(250ms);
  broker.watch(clock.now());

  std::vector<ReaderReport> readers;
  broker.report(readers);

  ASSERT_EQ(readers.size(), 2U) << "a tool is left out";
  EXPECT_EQ(readers[0].node, "/slow");
  EXPECT_EQ(readers[0].topic, "/image");
  EXPECT_EQ(readers[0].type, "sensor_msgs/msg/Image");
  EXPECT_EQ(readers[0].depth, 3U);
  EXPECT_EQ(readers[0].waiting, 2U);
  EXPECT_EQ(readers[0].delivered, 1U);
  EXPECT_EQ(readers[0].overwritten, 2U);
  EXPECT_EQ(readers[0].deadline_missed, 2U);
  EXPECT_TRUE(readers[0].open);
  EXPECT_EQ(readers[1].node, "/closed");
  EXPECT_EQ(readers[1].inactive, 5U);
  EXPECT_FALSE(readers[1].open);
  EXPECT_EQ(stream("/image").deadline_missed, 2U);
}

TEST_F(BrokerTest, every_reader_sees_the_writers_payload_address_and_nothing_is_copied) {
  auto writer = broker.create_writer(image_spec(10, "/camera"));
  std::vector<std::unique_ptr<Reader>> readers;
  for (const char* node : {"/a", "/b", "/c"})
    readers.push_back(broker.create_reader(image_spec(10, node), Taking::Share, nullptr));
  for (int i = 0; i < 20; ++i) {
    Block* const block = writer->borrow();
    auto& image = *static_cast<Image*>(block->message);
    image.data.resize(std::size_t{640} * 480 * 3);
    const void* const payload = image.data.data();
    writer->publish(*block);
    for (auto& reader : readers) {
      Block* const seen = reader->take();
      ASSERT_NE(seen, nullptr);
      EXPECT_EQ(static_cast<const Image*>(seen->message)->data.data(), payload);
      drop_reference(*seen);
    }
  }
  EXPECT_EQ(stream("/image").copies, 0U);
  EXPECT_EQ(stream("/image").bytes_copied, 0U);
  EXPECT_EQ(stream("/image").published, 20U);
  EXPECT_EQ(stream("/image").delivered, 60U);
  EXPECT_EQ(writer->counters().pool_grown, 3U) << "of large messages the queue's are made when they are needed";
}

TEST_F(BrokerTest, makes_what_small_messages_may_need_with_the_first_and_large_ones_when_they_are_needed) {
  const std::size_t small = 1000, large = 400'000;
  for (const std::size_t bytes : {small, large}) {
    auto writer = broker.create_writer(image_spec(10, "/camera"));
    auto reader = broker.create_reader(image_spec(10, "/a"), Taking::Share, nullptr);

    Block* const block = writer->borrow();
    static_cast<Image*>(block->message)->data.resize(bytes);
    writer->publish(*block);

    EXPECT_EQ(writer->counters().pool_grown, bytes == small ? 13U : 3U) << "depth 10, two for the reader, one to fill";
    drop_reference(*reader->take());
  }
}

TEST_F(BrokerTest, full_queues_and_busy_callbacks_need_no_more_messages_than_were_made_at_first) {
  auto a = broker.create_reader(image_spec(3, "/a"), Taking::Share, nullptr);
  auto writer = broker.create_writer(image_spec(3, "/camera"));  // joins one reader, and is joined by another
  auto b = broker.create_reader(image_spec(2, "/b"), Taking::Share, nullptr);
  const auto publish = [&] {
    Block* const block = writer->borrow();
    static_cast<Image*>(block->message)->data.resize(50000);
    writer->publish(*block);
  };
  publish();
  const test::AllocationGuard guard;
  Block* in_callback_a = nullptr;
  Block* in_callback_b = nullptr;
  for (int i = 0; i < 50; ++i) {
    publish();
    if (i % 7 == 0) {
      if (in_callback_a != nullptr) drop_reference(*in_callback_a);
      in_callback_a = a->take();
    }
    if (i % 11 == 0) {
      if (in_callback_b != nullptr) drop_reference(*in_callback_b);
      in_callback_b = b->take();
    }
  }
  EXPECT_EQ(guard.count(), 0U);
  drop_reference(*in_callback_a);
  drop_reference(*in_callback_b);
}

TEST_F(BrokerTest, a_listener_may_take_in_its_call_and_is_not_called_after_its_reader_is_gone) {
  struct Taker final : ReadyListener {
    void on_ready() noexcept override {
      Block* const block = reader->take();
      taken += block != nullptr ? 1 : 0;
      if (block != nullptr) drop_reference(*block);
      ++told;
    }
    Reader* reader = nullptr;
    int taken = 0, told = 0;
  } taker;
  auto writer = broker.create_writer(image_spec(10, "/camera"));
  auto reader = broker.create_reader(image_spec(10, "/a"), Taking::Share, &taker);
  taker.reader = reader.get();

  for (int i = 0; i < 3; ++i) writer->publish(*writer->borrow());
  reader.reset();
  writer->publish(*writer->borrow());

  EXPECT_EQ(taker.taken, 3);
  EXPECT_EQ(taker.told, 3);
}

TEST_F(BrokerTest, a_listener_that_takes_an_expired_message_gets_the_loss_without_deadlock) {
  struct Taker final : ReadyListener, StatusListener {
    void on_ready() noexcept override {
      clock->advance(2s);  // past the lifespan, between arrival and look
      EXPECT_EQ(reader->take(), nullptr);
    }
    void on_status() noexcept override { ++told; }
    test::ManualClock* clock = nullptr;
    Reader* reader = nullptr;
    int told = 0;
  } taker;
  EndpointSpec spec = image_spec(10, "/a");
  spec.status_listener = &taker;
  spec.tells_lost = true;
  auto reader = broker.create_reader(spec, Taking::Share, &taker);
  taker.clock = &clock;
  taker.reader = reader.get();
  EndpointSpec written = image_spec(10, "/camera");
  written.qos.lifespan(1s);
  auto writer = broker.create_writer(written);
  const int before = taker.told;

  writer->publish(*writer->borrow());

  EXPECT_EQ(taker.told, before + 1);
  EXPECT_EQ(reader->counters().expired, 1U);
}

// Design D4: owners only: the last in subscription order gets the original; with a reader present every owner gets a copy.
TEST_F(BrokerTest, copies_for_all_but_the_last_owner_and_for_every_owner_beside_a_reader) {
  for (const bool with_reader : {false, true}) {
    auto writer = broker.create_writer(image_spec(10, "/camera"));
    std::vector<std::unique_ptr<Reader>> owners;
    for (const char* node : {"/a", "/b", "/c"})
      owners.push_back(broker.create_reader(image_spec(10, node), Taking::Own, nullptr));
    std::unique_ptr<Reader> reader;
    if (with_reader) reader = broker.create_reader(image_spec(10, "/viewer"), Taking::Share, nullptr);
    Block* const block = writer->borrow();
    const void* const original = block->message;
    writer->publish(*block);
    int originals = 0;
    for (auto& owner : owners) {
      Block* const mine = owner->take();
      originals += mine->message == original ? 1 : 0;
      if (!with_reader && owner == owners.back()) { EXPECT_EQ(mine->message, original); }
      drop_reference(*mine);
    }
    EXPECT_EQ(originals, with_reader ? 0 : 1);
    EXPECT_EQ(writer->counters().copies, with_reader ? 3U : 2U);
    EXPECT_GT(writer->counters().bytes_copied, 0U);
  }
}

TEST_F(BrokerTest, hands_over_without_allocating_in_steady_state) {
  auto writer = broker.create_writer(image_spec(3, "/camera"));
  auto shared = broker.create_reader(image_spec(3, "/a"), Taking::Share, nullptr);
  auto pointer = broker.create_reader(image_spec(3, "/b"), Taking::Share, nullptr);
  const auto cycle = [&] {
    Block* const block = writer->borrow();
    auto& image = *static_cast<Image*>(block->message);
    image.data.resize(10000);
    image.header.frame_id = "a_frame_id_longer_than_the_small_string";
    writer->publish(*block);
    Block* const a = shared->take();
    drop_reference(*a);
    Block* const b = pointer->take();
    {
      const auto kept = share_block(*b);
      drop_reference(*b);
    }
  };
  for (int i = 0; i < 10; ++i) cycle();
  const test::AllocationGuard guard;
  for (int i = 0; i < 1000; ++i) cycle();
  EXPECT_EQ(guard.count(), 0U);
}

TEST_F(BrokerTest, gives_foreign_memory_back_with_the_last_reader) {
  auto writer = broker.create_writer(image_spec(10, "/camera"));
  auto a = broker.create_reader(image_spec(10, "/a"), Taking::Share, nullptr);
  auto b = broker.create_reader(image_spec(10, "/b"), Taking::Share, nullptr);
  static int returned;
  returned = 0;
  std::vector<std::uint8_t> mapped(100);
  Block* const block = writer->borrow();
  static_cast<Image*>(block->message)
      ->data.adopt(mapped.data(), 100, 100, {[](void*) noexcept { ++returned; }, nullptr});
  writer->publish(*block);
  drop_reference(*a->take());
  EXPECT_EQ(returned, 0);
  drop_reference(*b->take());
  EXPECT_EQ(returned, 1);
}

TEST_F(BrokerTest, a_pool_that_must_not_grow_drops_what_is_published_while_readers_keep_all_and_counts_it) {
  auto writer = broker.create_writer(image_spec(QoS(2).when_dry(PoolPolicy::Drop), "/camera"));
  auto reader = broker.create_reader(image_spec(QoS(2), "/a"), Taking::Share, nullptr);
  std::vector<Block*> kept;
  for (int i = 0; i < 5; ++i) {  // two in the queue, two of the reader, one to fill
    EXPECT_EQ(writer->publish(*writer->borrow()), PublishResult::Published);
    kept.push_back(reader->take());
  }
  const auto made = writer->counters().pool_grown;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(writer->publish(*writer->borrow()), PublishResult::PoolDry);
  EXPECT_EQ(reader->take(), nullptr);
  Block* const spare = writer->borrow();
  EXPECT_EQ(writer->borrow(), nullptr) << "the spare one is out";
  drop_reference(*spare);
  EXPECT_EQ(writer->counters().pool_dry, 4U);
  EXPECT_EQ(writer->counters().pool_grown, made);
  EXPECT_EQ(stream("/image").pool_dry, 4U);

  drop_reference(*kept.back());
  kept.pop_back();
  EXPECT_EQ(writer->publish(*writer->borrow()), PublishResult::Published);
  Block* const next = reader->take();
  ASSERT_NE(next, nullptr);
  EXPECT_EQ(next->info.sequence, 6U) << "a message that was never published is no gap";
  kept.push_back(next);
  for (Block* block : kept) drop_reference(*block);
}

TEST_F(BrokerTest, an_owners_copy_that_a_dry_pool_cannot_make_is_counted) {
  auto writer = broker.create_writer(image_spec(QoS(1).when_dry(PoolPolicy::Drop), "/camera"));
  auto sharer = broker.create_reader(image_spec(QoS(1), "/a"), Taking::Share, nullptr);
  auto owner = broker.create_reader(image_spec(QoS(1), "/b"), Taking::Own, nullptr);
  std::vector<Block*> kept;
  while (writer->counters().pool_dry == 0) {
    writer->publish(*writer->borrow());
    for (auto* reader : {sharer.get(), owner.get()}) {
      if (Block* const block = reader->take()) kept.push_back(block);
    }
    ASSERT_LT(kept.size(), 100U);
  }
  EXPECT_EQ(writer->counters().pool_grown, 1U + 2U * 2U + 1U + 1U)
      << "depth, two per reader, one to fill, the spare one";
  for (Block* block : kept) drop_reference(*block);
}

TEST_F(BrokerTest, a_pool_that_must_not_run_dry_reports_the_fault_once_each_time) {
  std::vector<std::string> told;
  EndpointSpec spec = image_spec(QoS(1).when_dry(PoolPolicy::Fail), "/camera");
  spec.on_fault = [&](const std::string& code, const std::string& text) { told.push_back(code + " " + text); };
  auto writer = broker.create_writer(spec);
  auto reader = broker.create_reader(image_spec(QoS(1), "/a"), Taking::Share, nullptr);
  for (std::size_t round = 1; round <= 2; ++round) {
    std::vector<Block*> kept;
    for (int i = 0; i < 4; ++i) {
      writer->publish(*writer->borrow());
      kept.push_back(reader->take());
    }
    EXPECT_EQ(told.size(), round - 1);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(writer->publish(*writer->borrow()), PublishResult::PoolDry);
    ASSERT_EQ(told.size(), round);
    EXPECT_EQ(
        told.back(),
        "POOL_DRY /image: its readers keep all 4 messages that their depths allow; let them keep fewer, give them a "
        "greater depth, or set when_dry: grow");
    for (Block* block : kept) drop_reference(*block);
    drop_reference(*writer->borrow());
  }
}

TEST_F(BrokerTest, names_both_ends_and_the_change_of_an_incompatible_pair) {
  auto writer = broker.create_writer(image_spec(QoS(10).best_effort(), "/camera"));
  auto reader = broker.create_reader(image_spec(QoS(10).reliable(), "/recorder"), Taking::Share, nullptr);
  const auto clashes = broker.clashes();
  ASSERT_EQ(clashes.size(), 1U);
  EXPECT_EQ(clashes[0].writer_node, "/camera");
  EXPECT_EQ(clashes[0].reader_node, "/recorder");
  EXPECT_EQ(clashes[0].policy, "reliability");
  EXPECT_FALSE(clashes[0].change.empty());
  // A node that hears it by another subscription misses nothing.
  auto second = broker.create_reader(image_spec(QoS(10).best_effort(), "/recorder"), Taking::Share, nullptr);
  EXPECT_TRUE(broker.clashes().empty());
}

TEST_F(BrokerTest, another_type_is_a_clash_unless_the_reader_takes_both) {
  const auto& text = std_msgs::msg::String::message_type();
  const auto& header = std_msgs::msg::Header::message_type();
  auto writer = broker.create_writer({"/cmd", &text, QoS(1), "/teleop"});
  auto other = broker.create_reader({"/cmd", &header, QoS(1), "/base"}, Taking::Share, nullptr);
  ASSERT_EQ(broker.clashes().size(), 1U);
  EXPECT_EQ(broker.clashes()[0].policy, "type");
  auto both = broker.create_reader({"/cmd", &text, QoS(1), "/base"}, Taking::Share, nullptr);
  EXPECT_TRUE(broker.clashes().empty());
}

TEST_F(BrokerTest, remembers_the_figures_of_endpoints_that_are_gone) {
  for (int round = 0; round < 2; ++round) {
    auto writer = broker.create_writer(image_spec(10, "/camera"));
    auto reader = broker.create_reader(image_spec(10, "/a"), Taking::Share, nullptr);
    writer->publish(*writer->borrow());
    drop_reference(*reader->take());
  }
  EXPECT_EQ(stream("/image").published, 2U);
  EXPECT_EQ(stream("/image").delivered, 2U);
  EXPECT_EQ(stream("/image").writers, 0U);
}

TEST_F(BrokerTest, says_whether_messages_stay_on_their_thread) {
  auto writer = broker.create_writer(image_spec(10, "/camera"));
  auto reader = broker.create_reader(image_spec(10, "/a"), Taking::Share, nullptr);
  EXPECT_EQ(stream("/image").handed_over, HandedOver::Never);
  const auto take = [&] {
    drop_reference(*reader->take());
    reader->note_latency(1us);
  };
  writer->publish(*writer->borrow());
  take();
  EXPECT_EQ(stream("/image").handed_over, HandedOver::Inline);
  std::thread([&] { writer->publish(*writer->borrow()); }).join();
  take();
  EXPECT_EQ(stream("/image").handed_over, HandedOver::AcrossThreads);
  writer.reset();
  EXPECT_EQ(stream("/image").handed_over, HandedOver::AcrossThreads) << "of endpoints that are gone too";
}

TEST_F(BrokerTest, keeps_nothing_of_writers_that_came_and_went_while_a_reader_held_their_last_message) {
  static int alive = 0;
  static msgs::MessageType counted = Image::message_type();  // outlives the broker
  counted.construct = [](void* at) {
    ++alive;
    Image::message_type().construct(at);
  };
  counted.destroy = [](void* at) noexcept {
    --alive;
    Image::message_type().destroy(at);
  };
  const auto reader = broker.create_reader({"/image", &counted, QoS(1), "/slow"}, Taking::Share, nullptr);
  int after_two = 0;
  for (int i = 0; i < 50; ++i) {
    const auto writer = broker.create_writer({"/image", &counted, QoS(1), "/visitor"});
    writer->publish(*writer->borrow());
    if (i == 1) after_two = alive;
  }
  EXPECT_LE(alive, after_two);
}

TEST_F(BrokerTest, names_the_holders_of_messages_of_a_destroyed_node) {
  auto reader = broker.create_reader(image_spec(10, "/a"), Taking::Share, nullptr);
  {
    auto writer = broker.create_writer(image_spec(10, "/camera"));
    writer->publish(*writer->borrow());
    writer->publish(*writer->borrow());
  }
  EXPECT_EQ(broker.sweep({"/camera"}), "2 messages of /image");
  drop_reference(*reader->take());
  EXPECT_EQ(broker.sweep({"/camera"}), "1 message of /image");
  drop_reference(*reader->take());
  EXPECT_EQ(broker.sweep({"/camera"}), "");
}

// --- topics that nothing uses any more ------------------------------------------------------------------------------------

// broker.cpp keeps so many for the report.
constexpr std::size_t kMostUnusedTopics = 256;

struct UnusedTopicsTest : Fixture {
  void open_and_close(std::size_t from, std::size_t to) {
    EndpointSpec spec = image_spec(QoS(1), "/node");
    for (std::size_t i = from; i < to; ++i) {
      spec.topic = "/topic_" + std::to_string(i);
      const auto writer = broker.create_writer(spec);
      writer->publish(*writer->borrow());
    }
  }
};

TEST_F(UnusedTopicsTest, forgets_the_oldest_unused_topics_and_keeps_the_totals_of_the_others) {
  const auto used = broker.create_writer(image_spec(QoS(1), "/camera"));
  used->publish(*used->borrow());
  open_and_close(0, 1000);

  broker.report(report);

  EXPECT_EQ(report.size(), 1 + kMostUnusedTopics);
  EXPECT_EQ(stream("/image").published, 1U);
  EXPECT_EQ(stream("/topic_999").published, 1U);
  EXPECT_EQ(stream("/topic_744").published, 1U);
  EXPECT_EQ(stream("/topic_743").name, "");
}

TEST_F(UnusedTopicsTest, counts_on_when_a_topic_is_used_again) {
  open_and_close(0, kMostUnusedTopics);
  open_and_close(0, 1);  // from now on the newest
  open_and_close(kMostUnusedTopics, kMostUnusedTopics + 10);
  EXPECT_EQ(stream("/topic_0").published, 2U);
  EXPECT_EQ(stream("/topic_1").name, "");
}

TEST_F(UnusedTopicsTest, forgets_a_topic_although_its_two_ends_leave_at_once) {
  open_and_close(0, kMostUnusedTopics - 1);
  for (int i = 0; i < 300; ++i) {
    EndpointSpec spec = image_spec(QoS(1), "/node");
    spec.topic = "/both_" + std::to_string(i);
    auto writer = broker.create_writer(spec);
    auto reader = broker.create_reader(spec, Taking::Share, nullptr);
    std::thread ending([&] { reader.reset(); });
    writer.reset();
    ending.join();
  }
  broker.report(report);
  EXPECT_EQ(report.size(), kMostUnusedTopics);
}

TEST_F(UnusedTopicsTest, keep_no_memory_for_names_that_were_once_opened) {
#ifdef NACELLE_SANITIZED
  GTEST_SKIP() << "the sanitizer's heap says nothing of sizes";
#endif
  const auto heap_in_use = [] { return static_cast<double>(::mallinfo2().uordblks); };
  open_and_close(0, 2000);
  const double before = heap_in_use();
  open_and_close(2000, 20'000);
  // Each topic that stayed would take 400 bytes and more: 7 MB in all. Names of one digit more take a few bytes each.
  EXPECT_LT(heap_in_use() - before, 64 * 1024);
}

}  // namespace
}  // namespace nacelle::runtime
