// SPDX-License-Identifier: Apache-2.0
// iceoryx's carrier against the laws of all carriers and against its own promises. One daemon serves the whole program.
#include <iceoryx_posh/popo/untyped_publisher.hpp>

#include "carrier_laws.hpp"
#include "nacelle/transport_iceoryx/iceoryx_carrier.hpp"
#include "support/allocation_guard.hpp"
#include "support/roudi.hpp"
#include "transport_iceoryx/wire/chunk.hpp"

namespace nacelle::test {
namespace {

using sensor_msgs::msg::Image;
using std_msgs::msg::String;
using transport_iceoryx::IceoryxCarrier;
using Sent = CarrierWriter::Sent;

class IceoryxFixture : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (roudi() == nullptr) roudi() = RouDi::start(small_pools(), why_not()).release();
  }
  void SetUp() override {
    if (roudi() == nullptr) GTEST_SKIP() << "SKIPPED, NOTHING WAS TESTED: " << why_not();
    auto started = IceoryxCarrier::start();
    ASSERT_TRUE(started) << started.error().text();
    carrier_ = std::move(started).value();
  }
  IceoryxCarrier& carrier() { return *carrier_; }

  // Never destroyed: its keeper ends it after this process has ended and iceoryx has unregistered.
  static RouDi*& roudi() {
    static RouDi* one = nullptr;
    return one;
  }
  static std::string& why_not() {
    static std::string why;
    return why;
  }

 private:
  std::unique_ptr<IceoryxCarrier> carrier_;
};

INSTANTIATE_TYPED_TEST_SUITE_P(Iceoryx, CarrierLaws, ::testing::Types<IceoryxFixture>);

/// Declared after its sink: the thread that reads may be delivering until the reader is gone.
struct Ends {
  std::unique_ptr<CarrierWriter> writer;
  std::unique_ptr<CarrierReader> reader;
};

class IceoryxCarrierTest : public CarrierLaws<IceoryxFixture> {
 protected:
  Ends open(const CarriedStream& stream, CarrierSink& sink) {
    Ends ends{carrier().create_writer(stream), carrier().create_reader(stream, sink)};
    EXPECT_TRUE(ends.writer && ends.reader);
    return ends;
  }
};

TEST_F(IceoryxCarrierTest, a_long_sequence_is_copied_once_by_the_writer_and_read_where_it_lies) {
  KeepingSink sink(Image::message_type());
  const Ends ends = open(image_stream(), sink);
  Sender<Image> sender(*ends.writer);

  ASSERT_EQ(sender.send(image_of(200'000, 1)), Sent::Yes);

  const auto arrived = sink.wait_for(1);
  EXPECT_TRUE(message_in<Image>(arrived[0]).data.is_foreign());
  EXPECT_EQ(carrier().reading().lent, 1U);
  EXPECT_EQ(carrier().reading().bytes_copied, 0U);
  EXPECT_GE(ends.writer->bytes_copied(), 200'000U);
  EXPECT_LT(ends.writer->bytes_copied(), 200'000U + 200U);
}

TEST_F(IceoryxCarrierTest, a_prepared_message_is_written_once_and_read_in_the_same_place) {
  KeepingSink sink(Image::message_type());
  const Ends ends = open(image_stream(), sink);
  Sender<Image> sender(*ends.writer);
  ASSERT_EQ(sender.send(image_of(200'000, 1)), Sent::Yes);  // announces the size
  static_cast<void>(sink.wait_for(1));
  sink.let_go();
  const auto copied_before = ends.writer->bytes_copied();

  for (std::uint8_t i = 2; i < 100; ++i) {
    Block& block = sender.borrow();
    auto& image = *static_cast<Image*>(block.message);
    EXPECT_EQ(image.data.size(), i == 2 ? 200'000U : 200'000U - i + 1) << "as the last message's";
    const Image like = image_of(200'000 - i, i);
    image.header = like.header;
    image.encoding = like.encoding;
    image.height = like.height;
    image.width = like.width;
    image.is_bigendian = like.is_bigendian;
    image.step = like.step;
    image.data.resize(like.data.size());
    std::memcpy(image.data.data(), like.data.data(), like.data.size());
    const auto* const written = image.data.data();
    ASSERT_EQ(sender.send(block), Sent::Yes);
    const auto arrived = sink.wait_for(1);
    ASSERT_EQ(message_in<Image>(arrived[0]).data.data(), written) << "one process maps the memory once";
    EXPECT_EQ(message_in<Image>(arrived[0]), like);
    sink.let_go();
  }
  EXPECT_EQ(ends.writer->bytes_copied(), copied_before);
}

TEST_F(IceoryxCarrierTest, a_prepared_message_with_another_owner_is_copied_and_counted) {
  KeepingSink sink(Image::message_type());
  const Ends ends = open(image_stream(), sink);
  Sender<Image> sender(*ends.writer);
  ASSERT_EQ(sender.send(image_of(50'000, 1)), Sent::Yes);
  const auto copied_before = ends.writer->bytes_copied();
  Block& block = sender.borrow();
  auto& image = *static_cast<Image*>(block.message);
  image = image_of(50'000, 2);  // a copy's memory is its own ...
  add_reference(block);         // a reader of this process
  ASSERT_EQ(sender.send(block), Sent::Yes);
  Block& second = sender.borrow();
  std::memset(static_cast<Image*>(second.message)->data.data(), 5, 50'000);  // ... and this is written in place
  add_reference(second);
  ASSERT_EQ(sender.send(second), Sent::Yes);

  const auto arrived = sink.wait_for(3);
  EXPECT_GE(ends.writer->bytes_copied(), copied_before + 100'000);
  EXPECT_NE(message_in<Image>(arrived[2]).data.data(), static_cast<Image*>(second.message)->data.data());
  EXPECT_EQ(message_in<Image>(arrived[2]).data[49'999], 5);
  drop_reference(block);
  drop_reference(second);
}

TEST_F(IceoryxCarrierTest, prepared_messages_that_are_never_sent_give_their_chunks_back_also_after_the_writer) {
  KeepingSink sink(Image::message_type());
  Ends ends = open(image_stream(), sink);
  auto sender = std::make_unique<Sender<Image>>(*ends.writer);
  ASSERT_EQ(sender->send(image_of(900'000, 1)), Sent::Yes);
  static_cast<void>(sink.wait_for(1));
  sink.let_go();

  for (int i = 0; i < 100; ++i) drop_reference(sender->borrow());  // of 24 chunks of that size
  EXPECT_TRUE(sender->send(image_of(900'000, 1)) == Sent::Yes);
  Block& out = sender->borrow();
  ASSERT_TRUE(static_cast<Image*>(out.message)->data.is_foreign());
  ends.writer.reset();
  std::memset(static_cast<Image*>(out.message)->data.data(), 1, 900'000);
  drop_reference(out);
}

TEST_F(IceoryxCarrierTest, a_sink_whose_readers_may_write_gets_memory_of_its_own) {
  KeepingSink sink(Image::message_type());
  sink.set_may_lend(false);
  const Ends ends = open(image_stream(), sink);
  Sender<Image> sender(*ends.writer);

  ASSERT_EQ(sender.send(image_of(50'000, 1)), Sent::Yes);

  EXPECT_FALSE(message_in<Image>(sink.wait_for(1)[0]).data.is_foreign());
  EXPECT_EQ(carrier().reading().bytes_copied, 50'000U);
}

TEST_F(IceoryxCarrierTest, a_reader_that_keeps_many_messages_gets_copies_and_does_not_exhaust_the_daemon) {
  KeepingSink sink(Image::message_type());
  const Ends ends = open(image_stream("/hoard", 1), sink);
  Sender<Image> sender(*ends.writer);

  for (std::uint8_t i = 0; i < 200; ++i) {  // of 64 chunks of that size
    ASSERT_EQ(sender.send(image_of(10'000, i)), Sent::Yes) << int{i};
    static_cast<void>(sink.wait_for(i + 1U));
  }

  const auto arrived = sink.wait_for(200);
  for (std::uint8_t i = 0; i < 200; ++i) EXPECT_EQ(message_in<Image>(arrived[i]), image_of(10'000, i));
  EXPECT_EQ(carrier().reading().lent, 9U) << "the depth and eight";
  EXPECT_EQ(carrier().reading().bytes_copied, 191U * 10'000U);
}

TEST_F(IceoryxCarrierTest, what_no_chunk_can_hold_is_refused_and_the_next_message_goes) {
  KeepingSink sink(Image::message_type());
  const Ends ends = open(image_stream(), sink);
  Sender<Image> sender(*ends.writer);

  EXPECT_EQ(sender.send(image_of(1'100'000, 1)), Sent::Refused);
  EXPECT_EQ(sender.send(image_of(1'000, 2)), Sent::Yes);

  EXPECT_EQ(message_in<Image>(sink.wait_for(1)[0]), image_of(1'000, 2));
}

TEST_F(IceoryxCarrierTest, when_the_daemon_has_no_chunk_left_it_is_refused_until_one_comes_back) {
  KeepingSink sink(Image::message_type());
  const Ends ends = open(image_stream("/large", 64), sink);
  Sender<Image> sender(*ends.writer);
  std::size_t sent = 0;
  while (sender.send(image_of(900'000, 1)) == Sent::Yes) static_cast<void>(sink.wait_for(++sent));
  EXPECT_GE(sent, 2U);
  EXPECT_LE(sent, 24U) << "chunks of that size";

  sink.let_go();

  EXPECT_EQ(sender.send(image_of(900'000, 1)), Sent::Yes);
}

TEST_F(IceoryxCarrierTest, more_depth_than_iceoryx_has_is_no_reader) {
  KeepingSink sink(String::message_type());
  EXPECT_EQ(carrier().create_reader(text_stream("/deep", 257), sink), nullptr);
  EXPECT_NE(carrier().create_reader(text_stream("/deep", 256), sink), nullptr);
}

TEST_F(IceoryxCarrierTest, more_readers_than_iceoryx_can_notify_are_refused_and_those_that_go_make_room) {
  KeepingSink sink(String::message_type());
  std::vector<std::unique_ptr<CarrierReader>> readers;
  for (int i = 0; i < 256; ++i)
    readers.push_back(carrier().create_reader(text_stream("/r" + std::to_string(i), 1), sink));
  ASSERT_NE(readers.back(), nullptr);

  EXPECT_EQ(carrier().create_reader(text_stream("/one_more", 1), sink), nullptr);
  readers.pop_back();
  EXPECT_NE(carrier().create_reader(text_stream("/one_more", 1), sink), nullptr);
}

TEST_F(IceoryxCarrierTest, a_slow_reader_loses_the_oldest_and_reports_it) {
  KeepingSink sink(String::message_type());
  // The thread that delivers is kept inside the sink's lock while more is sent than may wait.
  struct Slow final : CarrierSink {
    explicit Slow(KeepingSink& to) : to_(to) {}
    Block* borrow() noexcept override {
      const std::lock_guard lock(gate);
      return to_.borrow();
    }
    void deliver(Block& block, const MessageInfo& info) noexcept override { to_.deliver(block, info); }
    void note_broken(const char*) noexcept override {}
    std::mutex gate;
    KeepingSink& to_;
  } slow(sink);
  const Ends ends = open(text_stream("/slow", 2), slow);
  Sender<String> sender(*ends.writer);
  {
    const std::lock_guard closed(slow.gate);
    for (std::size_t i = 1; i <= 20; ++i) ASSERT_EQ(sender.send(text_of(i)), Sent::Yes);
  }
  ends.reader->drain();

  const auto arrived = sink.wait_for(2);
  EXPECT_LE(arrived.size(), 4U);
  EXPECT_EQ(message_in<String>(arrived.back()).data, text_of(20).data);
  EXPECT_EQ(arrived.back().info.sequence, 20U) << "the gap shows the loss";
  EXPECT_EQ(carrier().reading().overruns, 1U);
}

TEST_F(IceoryxCarrierTest, chunks_that_are_no_messages_are_reported_and_released) {
  KeepingSink sink(Image::message_type());
  const Ends ends = open(image_stream("/hostile"), sink);
  const iox::capro::ServiceDescription service{
      "nacelle/1/sensor_msgs/msg/Image",
      iox::capro::IdString_t(iox::cxx::TruncateToCapacity, Image::message_type().hash), "/hostile"};
  iox::popo::UntypedPublisher stranger(service);
  std::size_t told = 0;
  for (int i = 0; i < 300; ++i) {  // more than a reader may hold
    auto chunk = stranger.loan(5'000, 64);
    ASSERT_FALSE(chunk.has_error());
    auto* const bytes = static_cast<std::uint8_t*>(chunk.value());
    std::memset(bytes, i, 5'000);
    if (i % 3 != 0) {  // a head that is ours, over a body that is not
      const transport_iceoryx::PartPlace lies[] = {{i % 3 == 1 ? 4'992U : 64U, 4'936}};
      transport_iceoryx::write_head(bytes, {}, i % 2 == 0 ? 20 : 60'000, lies);
    }
    stranger.publish(chunk.value());
    static_cast<void>(sink.wait_for_broken(++told));
  }
  EXPECT_EQ(sink.count(), 0U);
  EXPECT_EQ(carrier().reading().broken, 300U);

  Sender<Image> sender(*ends.writer);
  ASSERT_EQ(sender.send(image_of(1'000, 2)), Sent::Yes);
  EXPECT_EQ(message_in<Image>(sink.wait_for(1)[0]), image_of(1'000, 2));
}

TEST_F(IceoryxCarrierTest, sending_takes_nothing_from_the_heap) {
  KeepingSink sink(Image::message_type());
  const Ends ends = open(image_stream(), sink);
  Sender<Image> sender(*ends.writer);
  for (std::size_t i = 0; i < 10; ++i) {
    ASSERT_EQ(sender.send(image_of(20'000, 1)), Sent::Yes);
    static_cast<void>(sink.wait_for(i + 1));
  }
  sink.let_go();
  std::uint64_t allocations = 0;

  for (std::size_t i = 0; i < 10; ++i) {
    Block& block = sender.borrow();
    const AllocationGuard guard;
    ASSERT_EQ(sender.send(block), Sent::Yes);
    allocations += guard.count();
    static_cast<void>(sink.wait_for(i + 1));
  }

  EXPECT_EQ(allocations, 0U);
}

}  // namespace
}  // namespace nacelle::test
