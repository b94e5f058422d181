// SPDX-License-Identifier: Apache-2.0
// One link at a time, by hand: hostile peers, types that do not fit, hubs, ends.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <std_msgs/msg/header.hpp>
#include <std_msgs/msg/string.hpp>

#include "support/linked_brokers.hpp"
#include "support/manual_clock.hpp"
#include "transport_local/wire/frame.hpp"

namespace nacelle {
namespace {

using std_msgs::msg::String;

EndpointSpec spec(const QoS& qos, const std::string& node) { return {"/chat", &String::message_type(), qos, node}; }

void send(Writer& writer, const std::string& text) {
  Block* const block = writer.borrow();
  static_cast<String*>(block->message)->data = text;
  static_cast<void>(writer.publish(*block));
}

std::string receive(Reader& reader) {
  std::string all;
  while (Block* const block = reader.take()) {
    all += static_cast<const String*>(block->message)->data;
    drop_reference(*block);
  }
  return all;
}

void settle(std::initializer_list<Link*> links) {
  for (bool moved = true; moved;) {
    moved = false;
    for (Link* const link : links) moved = link->pump() || moved;
  }
}

/// A graph with one reader, a link, and a peer of bytes.
class LinkTest : public ::testing::Test {
 protected:
  LinkTest() : link_(broker_, clock_, sockets_.one, options()) {}
  ~LinkTest() override { ::close(sockets_.two); }

  LinkOptions options() {
    LinkOptions options;
    options.peer = "the test";
    options.find_type = test::find_test_type;
    options.on_end = [this](const Problem& problem) { ends_.push_back(problem.text()); };
    return options;
  }
  void say(const std::function<void(Bytes&)>& append) {
    Bytes bytes;
    append(bytes);
    ASSERT_EQ(::send(sockets_.two, bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
    while (link_.pump()) {}
  }
  void greet() {
    say([](Bytes& out) { transport_local::append_hello(out, ""); });
  }
  void announce(const transport_local::EndpointFrame& endpoint) {
    say([&](Bytes& out) { transport_local::append_endpoint(out, endpoint); });
  }
  /// As the link has announced it.
  std::uint64_t reader_id() {
    Bytes bytes(4096);
    const ssize_t n = ::recv(sockets_.two, bytes.data(), bytes.size(), MSG_DONTWAIT);
    transport_local::LinkFrameReader frames;
    if (n > 0) {
      std::copy_n(bytes.begin(), n, frames.room().begin());
      frames.filled(static_cast<std::size_t>(n));
    }
    for (auto next = frames.next(); next && next.value(); next = frames.next()) {
      if (next.value()->kind == transport_local::LinkFrameKind::Reader)
        reader_id_ = transport_local::read_endpoint(*next.value())->id;
    }
    return reader_id_;
  }
  static transport_local::EndpointFrame writer_of_the_peer(std::uint64_t id = 7) {
    return {id, true, true, QoS(5), "/chat", String::message_type().name, String::message_type().hash, "/far"};
  }

  test::ManualClock clock_;
  runtime::Broker broker_{clock_};
  std::unique_ptr<Reader> reader_ = broker_.create_reader(spec(QoS(5), "/reader"), Taking::Share, nullptr);
  test::SocketPair sockets_;
  std::vector<std::string> ends_;
  std::uint64_t reader_id_ = 0;
  Link link_;
};

TEST_F(LinkTest, ends_when_the_peer_goes_and_takes_its_writers_along) {
  greet();
  announce(writer_of_the_peer());
  EXPECT_EQ(reader_->writer_count(), 1U);
  ::shutdown(sockets_.two, SHUT_RDWR);
  while (link_.pump()) {}
  EXPECT_TRUE(link_.has_ended());
  EXPECT_EQ(ends_, std::vector<std::string>{"the test: closed the link"});
  EXPECT_EQ(reader_->writer_count(), 0U);
  EXPECT_EQ(reader_->status().alive + reader_->status().not_alive, 0U);
}

TEST_F(LinkTest, ends_with_a_reason_on_garbage) {
  say([](Bytes& out) { out.assign(100, 'x'); });
  ASSERT_EQ(ends_.size(), 1U);
  EXPECT_NE(ends_[0].find("unknown kind"), std::string::npos) << ends_[0];
}

TEST_F(LinkTest, ends_on_an_id_that_is_taken) {
  greet();
  announce(writer_of_the_peer());
  announce(writer_of_the_peer());
  EXPECT_TRUE(link_.has_ended());
}

TEST_F(LinkTest, counts_what_is_no_message_and_goes_on) {
  greet();
  announce(writer_of_the_peer());
  const auto data = [&](std::uint64_t writer, std::vector<std::uint8_t> cdr, std::uint64_t sequence) {
    say([&](Bytes& out) {
      std::uint8_t* const at = transport_local::append_data(out, {writer, sequence, 1, kNeverExpires.nanoseconds(), {}},
                                                            {reader_id()}, cdr.size());
      std::copy(cdr.begin(), cdr.end(), at);
    });
  };
  data(7, {0, 1, 0, 0, 99, 0, 0, 0, 'x', 0}, 1);
  data(7, {}, 2);
  data(1234, {0, 1, 0, 0, 2, 0, 0, 0, 'x', 0}, 3);
  data(7, {0, 1, 0, 0, 2, 0, 0, 0, 'y', 0}, 4);
  EXPECT_EQ(receive(*reader_), "y");
  const LinkStats stats = link_.stats();
  EXPECT_EQ(stats.received, 4U);
  EXPECT_EQ(stats.broken, 2U);
  EXPECT_EQ(stats.dropped, 1U);
  EXPECT_FALSE(link_.has_ended());
}

TEST_F(LinkTest, refuses_streams_with_an_unknown_type_another_hash_or_no_name_and_keeps_the_others) {
  greet();
  auto other = writer_of_the_peer(20);
  other.hash = "RIHS01_00";
  announce(other);
  other = writer_of_the_peer(21);
  other.type = "nobody_msgs/msg/Knows";
  announce(other);
  other = writer_of_the_peer(22);
  other.topic = "/no such name";
  announce(other);
  EXPECT_EQ(reader_->writer_count(), 0U);
  EXPECT_FALSE(link_.has_ended());
  announce(writer_of_the_peer());
  EXPECT_EQ(reader_->writer_count(), 1U);
}

TEST_F(LinkTest, makes_stand_ins_only_for_what_this_side_uses) {
  greet();
  auto far = writer_of_the_peer(30);
  far.topic = "/unused";
  announce(far);
  std::vector<runtime::StreamReport> streams;
  broker_.report(streams);
  EXPECT_EQ(streams.size(), 1U);
  auto late = broker_.create_reader({"/unused", &String::message_type(), QoS(5), "/late"}, Taking::Share, nullptr);
  while (link_.pump()) {}
  EXPECT_EQ(late->writer_count(), 1U);
  late.reset();
  while (link_.pump()) {}
  EXPECT_EQ(link_.stats().dropped, 0U);
}

TEST_F(LinkTest, tells_a_type_clash_with_the_other_sides_node) {
  greet();
  auto far = writer_of_the_peer();
  far.type = std_msgs::msg::Header::message_type().name;
  far.hash = std_msgs::msg::Header::message_type().hash;
  announce(far);
  ASSERT_EQ(broker_.clashes().size(), 1U);
  EXPECT_EQ(broker_.clashes()[0].writer_node, "/far");
  EXPECT_EQ(broker_.clashes()[0].policy, "type");
}

TEST_F(LinkTest, does_not_believe_acknowledgements_of_what_was_never_sent) {
  greet();
  auto far = writer_of_the_peer(40);
  far.is_writer = false;
  far.qos = QoS(KeepAll{}).max_samples(2);
  announce(far);
  auto writer = broker_.create_writer(spec(QoS(5), "/writer"));
  while (link_.pump()) {}
  const auto result = [&] {
    Block* const block = writer->borrow();
    const PublishResult answer = writer->publish(*block);
    while (link_.pump()) {}
    return answer;
  };
  EXPECT_EQ(result(), PublishResult::Published);
  say([](Bytes& out) {
    transport_local::append_id_and_count(out, transport_local::LinkFrameKind::Taken, 40, 1'000'000);
  });
  EXPECT_EQ(result(), PublishResult::Published);
  EXPECT_EQ(result(), PublishResult::Published);
  EXPECT_EQ(result(), PublishResult::WouldBlock);
}

// --- several links ------------------------------------------------------------------------------------------------------

struct Pair {
  Pair(runtime::Broker& a, runtime::Broker& b, const Clock& clock) {
    const test::SocketPair sockets;
    LinkOptions options;
    options.mirror_all = true;
    options.find_type = test::find_test_type;
    one = std::make_unique<Link>(a, clock, sockets.one, options);
    two = std::make_unique<Link>(b, clock, sockets.two, options);
  }
  std::unique_ptr<Link> one, two;
};

TEST(LinkHub, carries_child_to_child_once_and_echoes_nothing) {
  const test::ManualClock clock;
  runtime::Broker hub{clock}, left{clock}, right{clock};
  const Pair to_left{hub, left, clock}, to_right{hub, right, clock};
  const auto run = [&] { settle({to_left.one.get(), to_left.two.get(), to_right.one.get(), to_right.two.get()}); };
  auto writer = left.create_writer(spec(QoS(5), "/left"));
  auto near = left.create_reader(spec(QoS(5), "/near"), Taking::Share, nullptr);
  auto middle = hub.create_reader(spec(QoS(5), "/middle"), Taking::Share, nullptr);
  auto far = right.create_reader(spec(QoS(KeepAll{}).max_samples(2), "/far"), Taking::Share, nullptr);
  run();
  for (const char* text : {"a", "b"}) {
    send(*writer, text);
    run();
  }
  EXPECT_EQ(receive(*near), "ab");
  EXPECT_EQ(receive(*middle), "ab");
  // The far end's room counts across both links.
  Block* const block = writer->borrow();
  EXPECT_EQ(writer->publish(*block), PublishResult::WouldBlock);
  run();
  EXPECT_EQ(receive(*far), "ab");
  run();
  send(*writer, "c");
  run();
  EXPECT_EQ(receive(*far), "c");
  EXPECT_EQ(far->counters().full, 1U);
  EXPECT_EQ(far->writer_count(), 1U);
  writer.reset();
  run();
  EXPECT_EQ(far->writer_count(), 0U);
}

TEST(LinkHub, tells_an_incompatible_pair_in_two_children_by_their_names) {
  const test::ManualClock clock;
  runtime::Broker hub{clock}, left{clock}, right{clock};
  const Pair to_left{hub, left, clock}, to_right{hub, right, clock};
  auto writer = left.create_writer(spec(QoS(5).best_effort(), "/left"));
  auto reader = right.create_reader(spec(QoS(5).reliable(), "/right"), Taking::Share, nullptr);
  settle({to_left.one.get(), to_left.two.get(), to_right.one.get(), to_right.two.get()});
  EXPECT_EQ(writer->status().incompatible_qos, 1U);
  EXPECT_NE(reader->status().last_clash.find("/left"), std::string::npos) << reader->status().last_clash;
  ASSERT_EQ(hub.clashes().size(), 1U);
  EXPECT_EQ(hub.clashes()[0].reader_node, "/right");
}

TEST(LinkNotes, arrive_behind_what_was_made_before_them) {
  const test::ManualClock clock;
  runtime::Broker here{clock}, there{clock};
  const test::SocketPair sockets;
  auto reader = there.create_reader(spec(QoS(5), "/there"), Taking::Share, nullptr);
  std::vector<std::size_t> writers;
  LinkOptions options;
  options.on_note = [&](const std::string& note) {
    EXPECT_EQ(note, "made");
    writers.push_back(reader->writer_count());
  };
  Link one{here, clock, sockets.one, {}};
  Link two{there, clock, sockets.two, options};
  auto writer = here.create_writer(spec(QoS(5), "/here"));
  one.send_note("made");
  settle({&one, &two});
  EXPECT_EQ(writers, std::vector<std::size_t>{1});
}

}  // namespace
}  // namespace nacelle
