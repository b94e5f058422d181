// SPDX-License-Identifier: Apache-2.0
#include "nacelle/io/reader_thread.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <optional>

#include "nacelle/io/pty_pair.hpp"
#include "nacelle/io/scripted_stream.hpp"
#include "nacelle/io/serial_port.hpp"

namespace nacelle::io {
namespace {

/// Records the arguments of its calls, and lets a test wait for them.
class RecordingSink final : public ByteSink {
 public:
  void on_bytes(ByteView bytes, MonotonicTime) override {
    note([&] {
      received.insert(received.end(), bytes.begin(), bytes.end());
      std::array<char, 16> name{};
      pthread_getname_np(pthread_self(), name.data(), name.size());
      thread_name = name.data();
    });
  }
  void on_silence(MonotonicTime) override {
    note([&] { ++silences; });
  }
  void on_break(StreamFault fault, MonotonicTime) override {
    note([&] { breaks.push_back(fault); });
  }
  void on_refusal(StreamFault) override {
    note([&] { note_attempt(); });
  }
  void on_return(MonotonicTime) override {
    note([&] {
      ++returns;
      note_attempt();
    });
  }

  MonotonicTime look_at(MonotonicTime latest) const override { return look.value_or(latest); }

  void wait_for(const std::function<bool()>& done) {
    std::unique_lock lock{mutex_};
    changed_.wait(lock, done);
  }

  Bytes received;
  std::optional<MonotonicTime> look;
  std::string thread_name;
  std::vector<StreamFault> breaks;
  int silences = 0, returns = 0;
  std::vector<int> silences_before_attempt;  ///< Calls of on_silence() before each attempt to open the line again.

 private:
  template <typename F>
  void note(F&& change) {
    const std::lock_guard lock{mutex_};
    change();
    changed_.notify_all();
  }
  void note_attempt() {
    silences_before_attempt.push_back(silences - silences_at_attempt_);
    silences_at_attempt_ = silences;
  }
  int silences_at_attempt_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
};

constexpr auto kBlocks = ScriptedStream::AtEnd::Blocks;

TEST(ReaderThread, hands_over_every_chunk_in_order_under_its_name) {
  const SystemClock clock;
  RecordingSink sink;
  ScriptedStream line{{{{}, {1, 2}}, {{}, {3}}}, kBlocks};
  ReaderThread reader{line, clock, sink, {.name = "a_name_longer_than_fits"}};

  sink.wait_for([&] { return sink.received.size() == 3; });
  reader.stop();

  EXPECT_EQ(sink.received, (Bytes{1, 2, 3}));
  EXPECT_EQ(sink.thread_name, "a_name_longer_t");
  EXPECT_EQ(reader.stats().bytes, 3U);
  EXPECT_EQ(reader.stats().chunks, 2U);
}

TEST(ReaderThread, waits_no_longer_than_the_sink_wants) {
  const SystemClock clock;
  RecordingSink sink;
  sink.look = MonotonicTime{7ms};
  std::atomic<std::int64_t> waited_until_ns{0};
  ScriptedStream line{
      {}, ScriptedStream::AtEnd::Silence, [&](MonotonicTime until) { waited_until_ns = until.nanoseconds(); }};
  ReaderThread reader{line, clock, sink, {.name = "test"}};

  sink.wait_for([&] { return sink.silences >= 2; });
  reader.stop();

  EXPECT_EQ(waited_until_ns, 7'000'000);
}

TEST(ReaderThread, opens_the_line_again_until_it_is_back) {
  const SystemClock clock;
  RecordingSink sink;
  ScriptedStream line{{{{}, {1}}, {{}, {}, StreamFault::HungUp}, {{}, {2}}}, kBlocks};
  line.refuse_reopen(3);
  ReaderThread reader{line, clock, sink, {.name = "test", .first_pause = 0ms}};

  sink.wait_for([&] { return sink.received.size() == 2; });
  reader.stop();

  EXPECT_EQ(sink.breaks, std::vector{StreamFault::HungUp});
  EXPECT_EQ(sink.returns, 1);
  EXPECT_EQ(sink.received, (Bytes{1, 2}));
  EXPECT_EQ(reader.stats().breaks, reader.stats().returns);
}

// After each Options::silence of a pause the sink gets on_silence(), so that these calls count the length of the pause.
TEST(ReaderThread, tries_without_limit_in_pauses_that_double_and_begin_short_again_after_bytes) {
  const SystemClock clock;
  RecordingSink sink;
  ScriptedStream line{{{{}, {}, StreamFault::HungUp}, {{}, {1}}, {{}, {}, StreamFault::HungUp}, {{}, {2}}}, kBlocks};
  line.refuse_reopen(30);
  ReaderThread reader{
      line, clock, sink, {.name = "test", .silence = 10us, .first_pause = 10us, .longest_pause = 100us}};

  sink.wait_for([&] { return sink.received.size() == 2; });
  reader.stop();

  std::vector<int> pauses{1, 2, 4, 8};
  pauses.resize(31, 10);  // 30 refusals, and the attempt that succeeds
  pauses.push_back(1);    // after the second break
  EXPECT_EQ(sink.silences_before_attempt, pauses);
  EXPECT_EQ(sink.received, (Bytes{1, 2}));
  EXPECT_EQ(reader.stats().breaks, 2U);
  EXPECT_EQ(reader.stats().returns, 2U);
}

TEST(ReaderThread, ends_with_the_first_break_if_it_shall_not_open_again) {
  const SystemClock clock;
  RecordingSink sink;
  ScriptedStream line{{{{}, {}, StreamFault::ReadFailed}}, kBlocks};
  ReaderThread reader{line, clock, sink, {.name = "test", .reopen = false}};

  sink.wait_for([&] { return !sink.breaks.empty(); });
  reader.stop();

  EXPECT_EQ(sink.returns, 0);
}

TEST(ReaderThread, stops_while_the_line_is_away) {
  const SystemClock clock;
  RecordingSink sink;
  ScriptedStream line{{{{}, {}, StreamFault::HungUp}}, kBlocks};
  line.refuse_reopen(1'000'000);
  ReaderThread reader{line, clock, sink, {.name = "test", .first_pause = std::chrono::hours{1}}};

  sink.wait_for([&] { return !sink.breaks.empty(); });
  reader.stop();

  EXPECT_EQ(reader.stats().breaks, 1U);
  EXPECT_EQ(reader.stats().returns, 0U);
}

TEST(ReaderThread, tells_about_silence) {
  const SystemClock clock;
  RecordingSink sink;
  ScriptedStream line{{}, ScriptedStream::AtEnd::Silence};
  ReaderThread reader{line, clock, sink, {.name = "test", .silence = 1ms}};
  sink.wait_for([&] { return sink.silences > 0; });
}

TEST(ReaderThread, makes_no_call_after_stop) {
  const SystemClock clock;
  RecordingSink sink;
  ScriptedStream line{{}, kBlocks};
  ReaderThread reader{line, clock, sink, {.name = "test"}};
  reader.stop();
  line.append({{}, {1}});
  reader.stop();
  EXPECT_TRUE(sink.received.empty());
}

/// Descriptors of this process.
std::size_t open_files() {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator{"/proc/self/fd"}, {}));
}

// Real kernel terminals: a cable that is pulled and plugged in again, as udev's link shows it.
TEST(ReaderThreadOnALine, two_hundred_pulled_cables_leak_nothing_and_every_gap_is_counted) {
  constexpr int kCycles = 200;
  const SystemClock clock;
  const std::string link = ::testing::TempDir() + "reader_unplugged_" + std::to_string(::getpid());
  auto device = PtyPair::create();
  ASSERT_TRUE(device && device.value()->link_as(link));
  auto port = SerialPort::open({link, 115200}, clock);
  ASSERT_TRUE(port);
  RecordingSink sink;
  ReaderThread reader{*port.value(), clock, sink, {.name = "cables", .silence = 10ms, .first_pause = 1ms}};
  const std::size_t files = open_files();

  for (int cycle = 0; cycle < kCycles; ++cycle) {
    const std::size_t before = sink.received.size();
    ASSERT_EQ(device.value()->write_some(Bytes{static_cast<std::uint8_t>(cycle)}), 1U);
    sink.wait_for([&] { return sink.received.size() == before + 1; });
    device.value()->hang_up();
    sink.wait_for([&] { return sink.breaks.size() == static_cast<std::size_t>(cycle) + 1; });
    device = PtyPair::create();
    ASSERT_TRUE(device && device.value()->link_as(link));
    sink.wait_for([&] { return sink.returns == cycle + 1; });
  }

  EXPECT_EQ(open_files(), files);
  reader.stop();
  EXPECT_EQ(reader.stats().breaks, kCycles);
  EXPECT_EQ(reader.stats().returns, kCycles);
  EXPECT_EQ(reader.stats().bytes, kCycles);
  EXPECT_EQ(sink.received.back(), kCycles - 1);
}

}  // namespace
}  // namespace nacelle::io
