// SPDX-License-Identifier: Apache-2.0
// Links with threads of their own, and with two real processes.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <std_msgs/msg/string.hpp>
#include <thread>

#include "support/linked_brokers.hpp"

namespace nacelle {
namespace {

using std_msgs::msg::String;
constexpr int kMessages = 2000;

EndpointSpec spec(const std::string& topic, const QoS& qos, const std::string& node) {
  return {topic, &String::message_type(), qos, node};
}

PublishResult send_text(Writer& writer, const std::string& text) {
  Block* const block = writer.borrow();
  static_cast<String*>(block->message)->data = text;
  return writer.publish(*block);
}

LinkOptions options_with(std::atomic<bool>* ended = nullptr) {
  LinkOptions options;
  options.mirror_all = true;
  options.find_type = test::find_test_type;
  if (ended != nullptr) options.on_end = [ended](const Problem&) { *ended = true; };
  return options;
}

/// The other process: publishes each number as soon as there is room, and publishes to "/echo" each message that it receives.
[[noreturn]] void be_the_other_process(int socket) {
  const SystemClock clock;
  runtime::Broker broker{clock, runtime::Watching::ByThread};
  LinkOptions options = options_with();
  options.on_end = [](const Problem&) { ::_exit(0); };
  Link link{broker, clock, socket, options};
  auto writer = broker.create_writer(spec("/numbers", QoS(10).reliable().max_blocking_time(10s), "/child"));
  link.start();
  while (writer->reader_count() == 0) std::this_thread::yield();
  for (int i = 0; i < kMessages; ++i) {
    while (send_text(*writer, std::to_string(i)) == PublishResult::WouldBlock) {}
  }
  for (;;) ::pause();
}

class OtherProcess {
 public:
  OtherProcess() {
    const test::SocketPair sockets;
    socket = sockets.one;
    pid = ::fork();
    if (pid == 0) {
      ::close(sockets.one);
      ::signal(SIGTERM, SIG_DFL);
      be_the_other_process(sockets.two);
    }
    ::close(sockets.two);
  }
  ~OtherProcess() { kill(); }
  void kill() {
    if (pid <= 0) return;
    ::kill(pid, SIGKILL);
    int status = 0;
    ::waitpid(pid, &status, 0);
    pid = -1;
  }
  int socket = -1;
  pid_t pid = -1;
};

TEST(LinkedProcesses, a_reliable_keep_all_stream_loses_nothing_and_a_kill_ends_it) {
  OtherProcess other;  // before this process has threads
  const SystemClock clock;
  runtime::Broker broker{clock, runtime::Watching::ByThread};
  std::atomic<bool> ended{false};
  auto reader = broker.create_reader(spec("/numbers", QoS(KeepAll{}).reliable().max_samples(7), "/parent"),
                                     Taking::Share, nullptr);
  Link link{broker, clock, other.socket, options_with(&ended)};
  link.start();
  for (int i = 0; i < kMessages; ++i) {
    Block* block = nullptr;
    while (!ended && (block = reader->take()) == nullptr) std::this_thread::yield();
    ASSERT_NE(block, nullptr);
    ASSERT_EQ(static_cast<const String*>(block->message)->data, std::to_string(i));
    drop_reference(*block);
  }
  EXPECT_EQ(reader->writer_count(), 1U);
  other.kill();
  while (!ended) std::this_thread::yield();
  EXPECT_EQ(reader->writer_count(), 0U);
}

TEST(LinkThreads, publishers_readers_and_endpoints_come_and_go_while_messages_flow) {
  const SystemClock clock;
  runtime::Broker one{clock, runtime::Watching::ByThread}, two{clock, runtime::Watching::ByThread};
  const test::SocketPair sockets;
  auto first = std::make_unique<Link>(one, clock, sockets.one, options_with());
  auto second = std::make_unique<Link>(two, clock, sockets.two, options_with());
  first->start();
  second->start();
  auto steady = two.create_reader(spec("/a", QoS(5).transient_local(), "/steady"), Taking::Share, nullptr);
  std::atomic<bool> over{false};
  std::thread writing([&] {
    for (int round = 0; round < 20; ++round) {
      auto writer = one.create_writer(spec("/a", QoS(5).transient_local(), "/w"));
      for (int i = 0; i < 50; ++i) static_cast<void>(send_text(*writer, std::to_string(i)));
    }
    over = true;
  });
  std::thread joining([&] {
    while (!over) {
      auto reader = two.create_reader(spec("/a", QoS(3), "/late"), Taking::Own, nullptr);
      while (Block* const block = reader->take()) drop_reference(*block);
    }
  });
  std::uint64_t last = 0, writer_id = 0;
  while (!over) {
    Block* const block = steady->take();
    if (block == nullptr) continue;
    // In order from each writer.
    EXPECT_TRUE(block->info.writer_id != writer_id || block->info.sequence > last);
    writer_id = block->info.writer_id;
    last = block->info.sequence;
    drop_reference(*block);
  }
  writing.join();
  joining.join();
  steady.reset();
  first.reset();
  second.reset();
}

TEST(LinkThreads, a_peer_that_does_not_read_blocks_nobody) {
  const SystemClock clock;
  runtime::Broker broker{clock};
  const test::SocketPair sockets;
  auto link = std::make_unique<Link>(broker, clock, sockets.one, options_with());
  link->start();
  // No thread reads the other end's socket; the test only writes its announcement by hand.
  runtime::Broker far{clock};
  auto reader = far.create_reader(spec("/a", QoS(3), "/far"), Taking::Share, nullptr);
  Link peer{far, clock, sockets.two, options_with()};
  while (peer.pump()) {}
  auto writer = broker.create_writer(spec("/a", QoS(3), "/w"));
  while (writer->reader_count() == 0) std::this_thread::yield();
  const std::string large(100'000, 'x');
  for (int i = 0; i < 100; ++i) EXPECT_EQ(send_text(*writer, large), PublishResult::Published);
  EXPECT_EQ(send_text(*writer, "last"), PublishResult::Published);
  // What could not be sent was overwritten, and the reader hears of it; the newest arrives.
  std::string newest;
  while (newest != "last") {
    peer.pump();
    while (Block* const block = reader->take()) {
      newest = static_cast<const String*>(block->message)->data;
      drop_reference(*block);
    }
  }
  while (reader->counters().overwritten + reader->counters().delivered != 101) peer.pump();
  link.reset();
}

}  // namespace
}  // namespace nacelle
