// SPDX-License-Identifier: Apache-2.0
// Streams that change between the socket and a carrier keep their order and lose nothing.
#include <gtest/gtest.h>

#include <std_msgs/msg/string.hpp>

#include "support/linked_brokers.hpp"
#include "support/manual_clock.hpp"
#include "support/queue_carrier.hpp"

namespace nacelle {
namespace {

using std_msgs::msg::String;

class CarriedStreams : public ::testing::Test {
 protected:
  CarriedStreams() {
    const test::SocketPair sockets;
    LinkOptions options;
    options.find_type = test::find_test_type;
    options.carrier = &carrier_;
    one_ = std::make_unique<Link>(here_, clock_, sockets.one, options);
    two_ = std::make_unique<Link>(there_, clock_, sockets.two, options);
  }
  static EndpointSpec spec(const QoS& qos, const std::string& node) {
    return {"/chat", &String::message_type(), qos, node};
  }
  void settle() {
    while (static_cast<int>(one_->pump()) + static_cast<int>(two_->pump()) != 0) {}
  }
  void publish(const std::string& text) {
    Block* const block = writer_->borrow();
    static_cast<String*>(block->message)->data = text;
    static_cast<void>(writer_->publish(*block));
  }
  void send(const std::string& text) {
    publish(text);
    settle();
  }
  static std::string receive(Reader& reader) {
    std::string all;
    while (Block* const block = reader.take()) {
      all += static_cast<const String*>(block->message)->data;
      drop_reference(*block);
    }
    return all;
  }
  void connect() {
    writer_ = here_.create_writer(spec(QoS(10), "/writer"));
    reader_ = there_.create_reader(spec(QoS(10), "/reader"), Taking::Share, nullptr);
    settle();
  }

  test::ManualClock clock_;
  test::QueueCarrier carrier_;
  runtime::Broker here_{clock_}, there_{clock_};
  std::unique_ptr<Link> one_, two_;
  std::unique_ptr<Writer> writer_;
  std::unique_ptr<Reader> reader_;
};

TEST_F(CarriedStreams, begin_on_the_socket_and_go_over_to_the_carrier) {
  connect();
  for (const char* text : {"a", "b", "c", "d"}) send(text);
  EXPECT_GE(carrier_.sent, 2U);
  EXPECT_EQ(one_->stats().sent + one_->stats().carried, 4U);
  carrier_.bring();
  EXPECT_EQ(receive(*reader_), "abcd");
}

TEST_F(CarriedStreams, keep_their_order_when_a_message_must_go_over_the_socket_in_between) {
  connect();
  for (const char* text : {"a", "b", "c"}) send(text);
  // A KEEP_ALL reader is acknowledged message by message, on the socket.
  auto all = there_.create_reader(spec(QoS(KeepAll{}).max_samples(5), "/all"), Taking::Share, nullptr);
  settle();
  send("d");
  send("e");
  EXPECT_EQ(receive(*reader_), "abcde") << "what the carrier held came first";
  EXPECT_EQ(receive(*all), "de");
  all.reset();
  settle();
  for (const char* text : {"f", "g"}) send(text);
  carrier_.bring();
  EXPECT_EQ(receive(*reader_), "fg");
}

TEST_F(CarriedStreams, stay_on_the_socket_for_good_after_a_refusal) {
  connect();
  for (const char* text : {"a", "b", "c"}) send(text);
  carrier_.refuses_messages = true;
  send("d");
  carrier_.refuses_messages = false;
  const std::size_t carried = carrier_.sent;
  send("e");
  EXPECT_EQ(carrier_.sent, carried);
  EXPECT_EQ(receive(*reader_), "abcde");
}

TEST_F(CarriedStreams, all_go_back_to_the_socket_when_the_carrier_dies) {
  connect();
  for (const char* text : {"a", "b", "c"}) send(text);
  carrier_.alive = false;
  send("d");
  send("e");
  EXPECT_EQ(receive(*reader_), "abcde");
}

TEST_F(CarriedStreams, stay_on_the_socket_when_the_other_side_cannot_take_them) {
  carrier_.refuses_readers = true;
  connect();
  for (const char* text : {"a", "b", "c"}) send(text);
  EXPECT_EQ(carrier_.sent, 0U);
  EXPECT_EQ(receive(*reader_), "abc");
}

TEST_F(CarriedStreams, hold_messages_back_while_the_change_is_agreed_on) {
  connect();
  send("a");
  send("b");
  // Several messages at once, at any step.
  for (const char* text : {"c", "d", "e"}) publish(text);
  settle();
  carrier_.bring();
  EXPECT_EQ(receive(*reader_), "abcde");
}

TEST_F(CarriedStreams, end_with_their_writer_and_bring_what_was_sent_before) {
  connect();
  for (const char* text : {"a", "b", "c"}) send(text);
  writer_.reset();
  settle();
  EXPECT_EQ(receive(*reader_), "abc");
}

TEST_F(CarriedStreams, cross_a_container_in_between_once) {
  // here_ is a child's, there_ the container's; a second child reads.
  runtime::Broker far{clock_};
  const test::SocketPair sockets;
  LinkOptions options;
  options.find_type = test::find_test_type;
  options.carrier = &carrier_;
  options.mirror_all = true;
  Link hub{there_, clock_, sockets.one, options};
  Link child{far, clock_, sockets.two, options};
  const auto settle_all = [&] {
    while (static_cast<int>(one_->pump()) + static_cast<int>(two_->pump()) + static_cast<int>(hub.pump()) +
               static_cast<int>(child.pump()) !=
           0) {}
  };
  connect();
  auto reader = far.create_reader(spec(QoS(10), "/far"), Taking::Share, nullptr);
  settle_all();
  for (const char* text : {"a", "b", "c", "d", "e"}) {
    publish(text);
    for (int hop = 0; hop < 3; ++hop) {
      settle_all();
      carrier_.bring();
    }
  }
  EXPECT_EQ(receive(*reader), "abcde");
  EXPECT_EQ(receive(*reader_), "abcde");
  EXPECT_GT(hub.stats().carried, 0U);
}

}  // namespace
}  // namespace nacelle
