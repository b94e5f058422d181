// SPDX-License-Identifier: Apache-2.0
#include "linked_by_iceoryx.hpp"

#include <gtest/gtest.h>

#include <sensor_msgs/msg/image.hpp>
#include <std_msgs/msg/string.hpp>

#include "nacelle/transport_iceoryx/iceoryx_carrier.hpp"
#include "support/manual_clock.hpp"
#include "support/roudi.hpp"

namespace nacelle::test {
namespace {

using sensor_msgs::msg::Image;
using std_msgs::msg::String;
using transport_iceoryx::IceoryxCarrier;

std::unique_ptr<IceoryxCarrier>& carrier() {
  static std::unique_ptr<IceoryxCarrier> one;
  return one;
}

/// One daemon and one carrier for the whole program.
class WithRouDi final : public ::testing::Environment {
 public:
  void SetUp() override {
    std::string why_not;
    // Never destroyed: its keeper ends it after this process has ended and iceoryx has unregistered.
    static const RouDi* const roudi = RouDi::start(small_pools(), why_not).release();
    if (roudi == nullptr) GTEST_SKIP() << "SKIPPED, NOTHING WAS TESTED: " << why_not;
    auto started = IceoryxCarrier::start();
    ASSERT_TRUE(started) << started.error().text();
    carrier() = std::move(started).value();
  }
  void TearDown() override { carrier().reset(); }
};
const auto* const environment = ::testing::AddGlobalTestEnvironment(new WithRouDi);

EndpointSpec spec(const QoS& qos) { return {"/chat", &String::message_type(), qos, "/node"}; }

// The suites would pass as well if the carrier never took a stream.
TEST(LinkedByIceoryx, moves_streams_by_the_carrier_and_those_of_keep_all_readers_by_the_socket) {
  for (const bool keeps_all : {false, true}) {
    ManualClock clock;
    LinkedByIceoryx transport{clock};
    auto writer = transport.create_writer(spec(10));
    auto reader = transport.create_reader(spec(keeps_all ? QoS(KeepAll{}) : QoS(10)), Taking::Share, nullptr);
    for (const char* text : {"a", "b", "c"}) {
      Block* const block = writer->borrow();
      static_cast<String*>(block->message)->data = text;
      writer->publish(*block);
      Block* const arrived = reader->take();
      ASSERT_NE(arrived, nullptr);
      EXPECT_EQ(static_cast<const String*>(arrived->message)->data, text);
      drop_reference(*arrived);
    }
    // The first message lets the link open a stream to carry.
    EXPECT_EQ(transport.writers_link().stats().carried, keeps_all ? 0U : 2U);
    EXPECT_EQ(transport.writers_link().stats().sent, keeps_all ? 3U : 1U);
  }
}

TEST(LinkedByIceoryx, writes_a_large_message_once_into_shared_memory_and_reads_it_there) {
  ManualClock clock;
  LinkedByIceoryx transport{clock};
  const EndpointSpec images{"/image", &Image::message_type(), QoS(4), "/node"};
  auto reader = transport.create_reader(images, Taking::Share, nullptr);
  auto writer = transport.create_writer(images);
  std::uint64_t copied = 0;
  // The first goes over the socket. The second announces their size.
  for (int i = 1; i <= 5; ++i) {
    Block* const block = writer->borrow();
    auto& image = *static_cast<Image*>(block->message);
    EXPECT_EQ(image.data.is_foreign(), i > 2) << i;
    image.data.resize(200'000);
    image.data[150'000] = static_cast<std::uint8_t>(i);
    writer->publish(*block);
    Block* const arrived = reader->take();
    ASSERT_NE(arrived, nullptr);
    const auto& seen = *static_cast<const Image*>(arrived->message);
    EXPECT_EQ(seen.data.is_foreign(), i > 1) << i;
    EXPECT_EQ(seen.data[150'000], i);
    drop_reference(*arrived);
    std::vector<runtime::StreamReport> streams;
    transport.writers().report(streams);
    ASSERT_EQ(streams.size(), 1U);
    if (i > 2) { EXPECT_EQ(streams[0].bytes_copied, copied) << i; }
    copied = streams[0].bytes_copied;
  }
  EXPECT_GE(copied, 2 * 200'000U) << "of the first two, and it is counted";
}

}  // namespace

LinkedByIceoryx::LinkedByIceoryx(const Clock& clock) : LinkedBrokers(clock, carrier().get()) {}

}  // namespace nacelle::test
