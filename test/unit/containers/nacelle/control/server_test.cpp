// SPDX-License-Identifier: Apache-2.0
#include "control/server.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "control/client.hpp"
#include "process/allocation_counter.hpp"
#include "process/process_figures.hpp"
#include "temporary_folder.hpp"

namespace nacelle::control {
namespace {

class FakeService final : public FastService {
 public:
  Result<std::uint16_t, std::string> open_writer(NamePair names) override {
    if (names.second != "some/msg/Type") return err(std::string{"no such type"});
    return static_cast<std::uint16_t>(opened++);
  }
  void close_writer(std::uint16_t) override { ++closed; }
  const char* publish(const Publication& publication) override {
    published_bytes += publication.cdr.size();
    return publication.cdr.empty() ? "empty" : nullptr;
  }
  TransformAnswer lookup(NamePair names) override {
    return {names.first == "odom", WallTime{42ns}, {1, 2, 3}, {0, 0, 0, 1}};
  }
  void append_stats(std::string& out) override { out.append(stats_bytes, 's'); }
  void request_shutdown() override { ++shutdowns; }
  bool is_emergency_stop(NamePair names) const override { return names.first == "/emergency_stop"; }
  void descriptors_ran_out(bool ran_out) override {
    ran_out_of_descriptors = ran_out;
    ran_out_of_descriptors.notify_all();
  }
  void descriptor_was_lost() override {}

  std::atomic<int> opened{0}, closed{0}, shutdowns{0};
  std::atomic<std::size_t> published_bytes{0};
  std::atomic<bool> ran_out_of_descriptors{false};
  std::size_t stats_bytes = 3000;
};

class ControlServerTest : public ::testing::Test {
 protected:
  ControlServerTest() { start({}); }
  void start(const ServerLimits& limits) {
    server_.reset();
    auto claim = SocketClaim::take({"", "", folder_.path() + "/s"}, "test");
    server_.emplace(std::move(claim).value(), service_, clock_, limits);
  }
  Client connect() const {
    auto client = Client::connect(server_->path());
    EXPECT_TRUE(client);
    return std::move(client).value();
  }
  /// A bare socket, for what Client would never send.
  int raw() const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, server_->path().c_str());
    const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return fd;
  }
  static bool is_closed_by_peer(int fd) {
    pollfd wait{fd, POLLIN, 0};
    char byte[4096];
    while (::poll(&wait, 1, 5000) == 1) {
      const ssize_t got = ::recv(fd, byte, sizeof byte, 0);
      if (got <= 0) return true;
    }
    return false;
  }

  TemporaryFolder folder_;
  const SystemClock clock_;
  FakeService service_;
  std::optional<ControlServer> server_;
};

TEST_F(ControlServerTest, answers_what_runs_at_a_rate) {
  Client client = connect();
  auto handle = client.open_writer("/cmd_vel", "some/msg/Type", 5s);
  ASSERT_TRUE(handle) << handle.error().text();
  ASSERT_TRUE(client.publish(handle.value(), as_bytes("12345")));
  auto transform = client.lookup("odom", "base", 5s);
  ASSERT_TRUE(transform);
  EXPECT_TRUE(transform.value().known);
  EXPECT_EQ(transform.value().translation_m[2], 3);
  EXPECT_EQ(service_.published_bytes, 5U) << "frames of one connection are served in order";
  auto stats = client.stats(5s);
  ASSERT_TRUE(stats);
  EXPECT_EQ(stats.value(), std::string(3000, 's'));
}

TEST_F(ControlServerTest, says_why_a_writer_was_not_opened) {
  Client client = connect();
  auto handle = client.open_writer("/cmd_vel", "wrong", 5s);
  ASSERT_FALSE(handle);
  EXPECT_EQ(handle.error().what, "no such type");
}

TEST_F(ControlServerTest, closes_the_writers_of_a_client_that_went) {
  {
    Client client = connect();
    ASSERT_TRUE(client.open_writer("/a", "some/msg/Type", 5s));
    ASSERT_TRUE(client.open_writer("/b", "some/msg/Type", 5s));
  }
  server_.reset();  // joins the thread, so all writers have been closed
  EXPECT_EQ(service_.closed, 2);
}

TEST_F(ControlServerTest, a_handle_belongs_to_its_connection) {
  Client owner = connect(), thief = connect();
  auto handle = owner.open_writer("/cmd_vel", "some/msg/Type", 5s);
  ASSERT_TRUE(handle);
  ASSERT_TRUE(thief.publish(handle.value(), as_bytes("x")));
  auto frame = thief.receive(5s);
  ASSERT_TRUE(frame && frame.value());
  EXPECT_EQ(frame.value()->kind, FrameKind::Fault);
  EXPECT_EQ(service_.published_bytes, 0U);
}

TEST_F(ControlServerTest, hands_json_requests_over_with_their_connection) {
  Client client = connect();
  ASSERT_TRUE(client.send(FrameKind::Request, R"({"verb":"x"})"));
  pollfd wait{server_->handed_over_descriptor(), POLLIN, 0};
  ASSERT_EQ(::poll(&wait, 1, 5000), 1);
  auto handed = server_->take_handed_over();
  ASSERT_EQ(handed.size(), 1U);
  EXPECT_EQ(handed[0].request, R"({"verb":"x"})");
  append_frame(handed[0].connection->out, FrameKind::Reply, R"({"ok":true,"n":7})");
  ASSERT_TRUE(handed[0].connection->write_some());
  auto reply = client.receive(5s);
  ASSERT_TRUE(reply && reply.value());
  EXPECT_EQ(as_text(reply.value()->payload), R"({"ok":true,"n":7})");
}

TEST_F(ControlServerTest, shutdown_is_asked_for_and_confirmed) {
  Client client = connect();
  ASSERT_TRUE(client.send(FrameKind::Shutdown, ""));
  auto frame = client.receive(5s);
  ASSERT_TRUE(frame && frame.value());
  EXPECT_EQ(frame.value()->kind, FrameKind::Shutdown);
  EXPECT_EQ(service_.shutdowns, 1);
}

TEST_F(ControlServerTest, noise_ends_its_own_connection_only) {
  const unsigned seed = 99;
  std::mt19937 random{seed};
  Client good = connect();
  for (int round = 0; round < 100; ++round) {
    const int fd = raw();
    std::string noise(1 + random() % 600, '\0');
    for (char& c : noise) c = static_cast<char>(random());
    noise[3] = 0x7F;  // a length beyond every bound
    static_cast<void>(!::send(fd, noise.data(), noise.size(), MSG_NOSIGNAL));
    // Fewer bytes than a header are no frame yet: the end of the connection ends it.
    if (noise.size() >= kFrameHeaderBytes) {
      EXPECT_TRUE(is_closed_by_peer(fd)) << "seed " << seed << ", round " << round;
    }
    ::close(fd);
  }
  EXPECT_TRUE(good.stats(5s));
}

TEST_F(ControlServerTest, half_a_frame_does_not_block_other_clients) {
  const int fd = raw();
  const std::string half{"\x10\0\0\0p\x01", 6};
  ASSERT_EQ(::send(fd, half.data(), half.size(), 0), 6);
  Client good = connect();
  EXPECT_TRUE(good.stats(5s));
  ::close(fd);
}

TEST_F(ControlServerTest, a_client_that_never_reads_has_bounded_cost_and_does_not_block_others) {
  service_.stats_bytes = 60000;
  const int fd = raw();
  std::string questions;
  for (int i = 0; i < 1000; ++i) append_frame(questions, FrameKind::Stats, "");
  // 60 MB of answers were asked for; the kernel's and the server's buffers hold a few hundred kB.
  static_cast<void>(!::send(fd, questions.data(), questions.size(), MSG_NOSIGNAL | MSG_DONTWAIT));
  Client good = connect();
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(good.stats(5s));
  // When it reads after all, everything comes, in order and whole.
  FrameReader reader{1U << 20U};
  int answers = 0;
  while (answers < 1000) {
    const ByteSpan room = reader.room();
    pollfd wait{fd, POLLIN, 0};
    ASSERT_EQ(::poll(&wait, 1, 5000), 1) << "after " << answers;
    const ssize_t got = ::recv(fd, room.data(), room.size(), 0);
    ASSERT_GT(got, 0);
    reader.filled(static_cast<std::size_t>(got));
    while (true) {
      auto frame = reader.next();
      ASSERT_TRUE(frame);
      if (!frame.value()) break;
      ASSERT_EQ(frame.value()->payload.size(), 60000U);
      ++answers;
    }
  }
  ::close(fd);
}

/// As `nacelle estop set` does it.
bool can_stop(Client& client) {
  if (!client.stats(5s)) return false;
  const auto handle = client.open_writer("/emergency_stop", "some/msg/Type", 5s);
  return handle && client.publish(handle.value(), as_bytes("1")) && client.stats(5s);
}

TEST_F(ControlServerTest, accepts_a_stop_when_all_connections_are_in_use) {
  start({.guests = 8, .makes_room_after = 1h});
  std::vector<Client> crowd;
  for (int i = 0; i < 8; ++i) {
    crowd.push_back(connect());
    ASSERT_TRUE(crowd.back().stats(5s));
  }
  // Silent connections on reserved places must not block it either.
  std::vector<int> silent;
  for (int i = 0; i < 20; ++i) silent.push_back(raw());

  Client stopping = connect();
  EXPECT_TRUE(can_stop(stopping));
  EXPECT_EQ(service_.published_bytes, 1U);
  EXPECT_EQ(server_->stats().turned_away, 17U) << "four are reserved";

  for (const int fd : silent) ::close(fd);
}

TEST_F(ControlServerTest, refuses_other_requests_when_all_connections_are_in_use) {
  start({.guests = 2, .makes_room_after = 1h});
  Client one = connect(), two = connect();
  ASSERT_TRUE(one.stats(5s) && two.stats(5s));
  for (int i = 0; i < 2; ++i) {
    Client third = connect();
    const auto answer =
        i == 0 ? third.call({{"verb", "x"}}, 5s).error() : third.open_writer("/cmd_vel", "some/msg/Type", 5s).error();
    EXPECT_NE(answer.text().find("only emergency stops and shutdown are accepted"), std::string::npos) << answer.text();
  }
  EXPECT_TRUE(one.stats(5s)) << "existing connections stay";
}

TEST_F(ControlServerTest, closes_the_longest_idle_connection_for_a_new_one) {
  start({.guests = 3, .makes_room_after = 0ns});
  Client first = connect(), second = connect(), third = connect();
  ASSERT_TRUE(first.stats(5s) && second.stats(5s) && third.stats(5s) && first.stats(5s));

  Client fourth = connect();
  ASSERT_TRUE(fourth.lookup("odom", "base", 5s)) << "it has an ordinary place";

  const auto refused = second.stats(5s);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("closed as the longest idle connection"), std::string::npos)
      << refused.error().text();
  EXPECT_TRUE(first.stats(5s));
  EXPECT_TRUE(third.stats(5s));
}

TEST_F(ControlServerTest, closes_idle_connections_but_not_publishers) {
  start({.idle = 50ms});
  Client publisher = connect();
  const auto handle = publisher.open_writer("/cmd_vel", "some/msg/Type", 5s);
  ASSERT_TRUE(handle);
  const int silent = raw();
  EXPECT_TRUE(is_closed_by_peer(silent));
  ::close(silent);
  EXPECT_TRUE(publisher.publish(handle.value(), as_bytes("x")) && publisher.stats(5s));
}

TEST_F(ControlServerTest, bounds_requests_that_the_main_thread_has_not_taken) {
  start({.guests = 4});
  std::vector<Client> waiting;
  for (int i = 0; i < 4; ++i) {
    waiting.push_back(connect());
    ASSERT_TRUE(waiting.back().send(FrameKind::Request, "{}"));
  }
  // Of one connection after the other, so the fifth is behind the others.
  while (server_->stats().handed_over < 4) ASSERT_TRUE(connect().stats(5s));
  Client fifth = connect();
  const auto refused = fifth.call({{"verb", "x"}}, 5s);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("too many requests are pending"), std::string::npos) << refused.error().text();
}

/// Takes every descriptor that the process may open.
class AllDescriptors {
 public:
  AllDescriptors() {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    rlimit fewer = before_;
    fewer.rlim_cur = 256;
    ::setrlimit(RLIMIT_NOFILE, &fewer);
    for (int fd = 0; (fd = ::open("/dev/null", O_RDONLY | O_CLOEXEC)) >= 0;) taken_.push_back(fd);
  }
  AllDescriptors(const AllDescriptors&) = delete;
  AllDescriptors& operator=(const AllDescriptors&) = delete;
  ~AllDescriptors() {
    for (const int fd : taken_) ::close(fd);
    ::setrlimit(RLIMIT_NOFILE, &before_);
  }

 private:
  rlimit before_{};
  std::vector<int> taken_;
};

TEST_F(ControlServerTest, accepts_a_stop_without_a_free_descriptor) {
  start({.makes_room_after = 1h});
  Client first = connect();
  ASSERT_TRUE(first.stats(5s));
  // Sockets of the clients' side, which live in this process, too.
  std::array<int, 3> sockets{};
  for (int& fd : sockets) fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, server_->path().c_str());
  const auto connected = [&](int fd) {
    EXPECT_EQ(::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return Client::over(fd, 0ns);
  };
  {
    const AllDescriptors all;
    // One that asks for something else gets the kept descriptor first, and gives it away again.
    Client other = connected(sockets[0]);
    const auto refused = other.lookup("odom", "base", 5s);
    ASSERT_FALSE(refused);
    service_.ran_out_of_descriptors.wait(false);
    Client silent = connected(sockets[1]), stopping = connected(sockets[2]);
    EXPECT_TRUE(can_stop(stopping));

    EXPECT_TRUE(first.stats(5s)) << "existing connections are served";
  }
  service_.ran_out_of_descriptors.wait(true);  // the service is notified of the recovery
  Client later = connect();
  EXPECT_TRUE(later.lookup("odom", "base", 5s));
}

TEST_F(ControlServerTest, answering_at_a_rate_allocates_nothing_on_its_thread) {
#ifdef NACELLE_SANITIZED
  GTEST_SKIP() << "a sanitizer owns the allocator";
#endif
  ASSERT_TRUE(process::allocations_are_counted());
  Client client = connect();
  auto handle = client.open_writer("/cmd_vel", "some/msg/Type", 5s);
  ASSERT_TRUE(handle);
  const auto ask = [&] {
    ASSERT_TRUE(client.publish(handle.value(), as_bytes("0123456789")));
    ASSERT_TRUE(client.lookup("odom", "base", 5s));
    ASSERT_TRUE(client.stats(5s));
  };
  for (int i = 0; i < 10; ++i) ask();
  const auto threads = process::living_threads();
  process::AllocationSnapshot before, after;
  process::take_snapshot(before);
  for (int i = 0; i < 200; ++i) ask();
  // A command that searches for containers connects to each, and disconnects again. Asking in between makes sure that
  // the server saw it go: a crowd that comes at once may cost heap, one after the other must not.
  for (int i = 0; i < 50; ++i) {
    ::close(raw());
    ask();
  }
  process::take_snapshot(after);
  auto rates = process::allocation_rates(before, after, threads, 1.0);
  ASSERT_EQ(rates.count("control"), 1U);
  EXPECT_EQ(rates["control"], 0);
}

}  // namespace
}  // namespace nacelle::control
