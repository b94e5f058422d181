// SPDX-License-Identifier: Apache-2.0
// What ends while messages flow, and what stays behind.
#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <functional>
#include <thread>
#include <variant>
#include <vector>

#include "support/dds.hpp"

namespace nacelle::transport_dds {
namespace {

TEST(Ending, of_a_reader_under_traffic_does_no_harm) {
  test::Told told;
  const auto here = test::make_participant(), there = test::make_participant();
  const auto options = test::string_topic("traffic", QoS(5));
  const auto writer = here->create_writer(options, &told).value();
  std::atomic<bool> stop{false};
  std::thread writing([&] {
    while (!stop) static_cast<void>(test::say(*writer, std::string(3000, 'x')));
  });
  for (int i = 0; i < 50; ++i) {
    const auto reader = there->create_reader(options, &told).value();
    const auto own = here->create_reader(options, &told).value();
    EXPECT_TRUE(told.until([&] { return reader->counters().received > 3 && own->counters().received > 3; })) << i;
  }
  stop = true;
  writing.join();
}

TEST(Ending, of_a_writer_and_its_participant_under_traffic_does_no_harm) {
  test::Told told;
  const auto there = test::make_participant();
  const auto options = test::string_topic("goes_down", QoS(5));
  const auto reader = there->create_reader(options, &told).value();
  for (int i = 0; i < 10; ++i) {
    const std::uint64_t before = reader->counters().received;
    auto here = test::make_participant();
    const auto writer = here->create_writer(options, &told).value();
    here.reset();
    ASSERT_TRUE(told.until([&] { return writer->matched_count() == 1 && reader->matched_count() >= 1; })) << i;
    for (int message = 0; message < 20; ++message) static_cast<void>(test::say(*writer, std::string(100000, 'x')));
    EXPECT_TRUE(told.until([&] { return reader->counters().received > before; })) << i;
  }
  EXPECT_TRUE(told.until([&] { return reader->matched_count() == 0; }));
}

TEST(Ending, of_a_reader_leaves_taken_messages_whole) {
  test::Told told;
  const auto here = test::make_participant();
  auto there = test::make_participant();
  const auto options = test::string_topic("taken");
  const auto writer = here->create_writer(options, &told).value();
  auto reader = there->create_reader(options, &told).value();
  ASSERT_TRUE(told.until([&] { return writer->matched_count() == 1 && reader->matched_count() == 1; }));
  ASSERT_EQ(test::say(*writer, "kept"), Writer::Sent::Yes);
  ASSERT_TRUE(told.until([&] { return reader->has_waiting(); }));
  const auto sample = reader->take();
  reader.reset();
  there.reset();
  ASSERT_TRUE(sample);
  EXPECT_EQ(to_hex(sample->payload.bytes()), "00010000050000006b65707400000000");
}

std::size_t heap_in_use() {
  ::malloc_trim(0);
  const auto info = ::mallinfo2();
  return info.uordblks + info.hblkhd;
}

/// Counts the endpoints of one participant that another knows.
class Peer {
 public:
  explicit Peer(Gid of) : of_(of) {}
  /// Returns when it knows so many.
  [[nodiscard]] bool sees(std::size_t endpoints) {
    return told_.until([&] {
      while (discovery_->take(events_, 100)) {}
      for (const DiscoveryEvent& event : events_) {
        const auto* const end = std::get_if<DiscoveredEndpoint>(&event.what);
        if (end == nullptr || !end->gid.same_participant(of_)) continue;
        if (event.kind == DiscoveryEvent::Kind::Appeared) ++known_;
        if (event.kind == DiscoveryEvent::Kind::Gone) --known_;
      }
      events_.clear();
      return known_ == endpoints;
    });
  }
  [[nodiscard]] Participant& participant() { return *participant_; }

 private:
  const Gid of_;
  test::Told told_;
  std::size_t known_ = 0;
  std::vector<DiscoveryEvent> events_;
  std::unique_ptr<Participant> participant_ = test::make_participant();
  std::unique_ptr<Discovery> discovery_ = participant_->create_discovery(&told_).value();
};

// What Cyclone's receive buffers and free lists hold at that moment: up to 40 KB with two participants. Each of the 1000
// endpoints whose announcement stayed would add 500 bytes.
constexpr double kMostGrown = 128 * 1024;

double heap_grown_by(const std::function<void()>& cycle) {
  for (int i = 0; i < 100; ++i) cycle();
  const std::size_t before = heap_in_use();
  for (int i = 0; i < 500; ++i) cycle();
  const double grown = static_cast<double>(heap_in_use()) - static_cast<double>(before);
  ::testing::Test::RecordProperty("bytes_grown", std::to_string(grown));
  return grown;
}

TEST(Ending, of_a_thousand_endpoints_leaves_no_memory_behind) {
#ifdef NACELLE_SANITIZED
  GTEST_SKIP() << "the sanitizer's heap says nothing of sizes";
#endif
  const auto participant = test::make_participant();
  const double grown = heap_grown_by([&] {
    const auto options = test::string_topic("cycle");
    const auto writer = participant->create_writer(options, nullptr).value();
    const auto reader = participant->create_reader(options, nullptr).value();
    EXPECT_EQ(test::say(*writer, "x"), Writer::Sent::Yes);
  });
  EXPECT_LT(grown, kMostGrown);
}

TEST(Ending, of_a_thousand_matched_endpoints_leaves_no_memory_behind_on_either_side) {
#ifdef NACELLE_SANITIZED
  GTEST_SKIP() << "the sanitizer's heap says nothing of sizes";
#endif
  const auto participant = test::make_participant();
  Peer peer(participant->gid());
  test::Told told;
  const auto options = test::string_topic("cycle", QoS(1).transient_local());
  const auto there = peer.participant().create_reader(options, &told).value();
  const double grown = heap_grown_by([&] {
    {
      const auto writer = participant->create_writer(options, &told).value();
      const auto reader = participant->create_reader(options, &told).value();
      EXPECT_EQ(test::say(*writer, "x"), Writer::Sent::Yes);
      EXPECT_TRUE(told.until([&] { return there->take().has_value(); }));
      EXPECT_TRUE(peer.sees(2));
    }
    EXPECT_TRUE(peer.sees(0));
  });
  EXPECT_LT(grown, kMostGrown);
}

TEST(Ending, of_a_participant_gives_its_memory_back) {
#ifdef NACELLE_SANITIZED
  GTEST_SKIP() << "the sanitizer's heap says nothing of sizes";
#endif
  const auto cycle = [] {
    const auto participant = test::make_participant();
    for (int i = 0; i < 300; ++i) {
      const auto writer = participant->create_writer(test::string_topic("cycle"), nullptr).value();
      const auto reader = participant->create_reader(test::string_topic("cycle"), nullptr).value();
      ASSERT_EQ(test::say(*writer, "x"), Writer::Sent::Yes);
    }
  };
  for (int i = 0; i < 3; ++i) cycle();
  const std::size_t before = heap_in_use();
  for (int i = 0; i < 5; ++i) cycle();
  const double grown = static_cast<double>(heap_in_use()) - static_cast<double>(before);
  EXPECT_LT(grown / 3000, 16) << "bytes for each endpoint";
}

}  // namespace
}  // namespace nacelle::transport_dds
