// SPDX-License-Identifier: Apache-2.0
#include "linked_by_iceoryx.hpp"

#include <gtest/gtest.h>

#include <std_msgs/msg/string.hpp>

#include "nacelle/transport_iceoryx/iceoryx_carrier.hpp"
#include "support/manual_clock.hpp"
#include "support/roudi.hpp"

namespace nacelle::test {
namespace {

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
    // Never destroyed: its keeper ends it when this process has ended, after iceoryx has said goodbye.
    if (RouDi::start(small_pools(), why_not).release() == nullptr)
      GTEST_SKIP() << "SKIPPED, NOTHING WAS TESTED: " << why_not;
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
    EXPECT_EQ(transport.writers_link().stats().carried, keeps_all ? 0U : 3U);
    EXPECT_EQ(transport.writers_link().stats().sent, keeps_all ? 3U : 0U);
  }
}

}  // namespace

LinkedByIceoryx::LinkedByIceoryx(const Clock& clock) : LinkedBrokers(clock, carrier().get()) {}

}  // namespace nacelle::test
