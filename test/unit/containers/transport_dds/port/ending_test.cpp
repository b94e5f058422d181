// SPDX-License-Identifier: Apache-2.0
// What ends while messages flow, and what stays behind.
#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <thread>
#include <vector>

#include "support/dds.hpp"

namespace nacelle::transport_dds {
namespace {

TEST(Ending, of_a_reader_under_traffic_harms_nobody) {
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

TEST(Ending, of_a_writer_and_its_participant_under_traffic_harms_nobody) {
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

TEST(Ending, of_a_thousand_endpoints_leaves_what_cyclone_is_known_to_keep) {
#ifdef NACELLE_SANITIZED
  GTEST_SKIP() << "the sanitizer's heap says nothing of sizes";
#endif
  const auto participant = test::make_participant();
  const auto cycle = [&](int times) {
    for (int i = 0; i < times; ++i) {
      const auto options = test::string_topic("cycle");
      const auto writer = participant->create_writer(options, nullptr).value();
      const auto reader = participant->create_reader(options, nullptr).value();
      ASSERT_EQ(test::say(*writer, "x"), Writer::Sent::Yes);
    }
  };
  cycle(200);
  const std::size_t before = heap_in_use();
  cycle(1000);
  const std::size_t after = heap_in_use();
  // 0.3 to 0.4 KiB for each reader and each writer in Cyclone's own lists, until the participant ends.
  const double kib = (static_cast<double>(after) - static_cast<double>(before)) / 1024 / 2000;
  RecordProperty("kib_per_endpoint", std::to_string(kib));
  EXPECT_LT(kib, 0.5);
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
