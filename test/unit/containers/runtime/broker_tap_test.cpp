// SPDX-License-Identifier: Apache-2.0
// For a link that has an endpoint of its own for each writer: taps, and witnesses for the readers that they serve.
#include <gtest/gtest.h>

#include <std_msgs/msg/string.hpp>
#include <string>
#include <vector>

#include "nacelle/runtime/broker.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::runtime {
namespace {

using std_msgs::msg::String;
using Texts = std::vector<std::string>;

class BrokerTap : public ::testing::Test, public GraphListener {
 public:
  void on_made(const EndpointInfo& endpoint) noexcept override { made.push_back(endpoint); }
  void on_gone(std::uint64_t) noexcept override {}
  void on_gate(std::uint64_t, bool) noexcept override {}
  void on_life(std::uint64_t) noexcept override {}
  void on_left(std::uint64_t) noexcept override {}

  static EndpointSpec spec(const QoS& qos = QoS(10), const std::string& node = "/node") {
    return {"/chat", &String::message_type(), qos, node};
  }
  static void send(Writer& writer, const std::string& text) {
    Block* const block = writer.borrow();
    static_cast<String*>(block->message)->data = text;
    writer.publish(*block);
  }
  static Texts receive(Reader& reader) {
    Texts all;
    while (Block* const block = reader.take()) {
      all.push_back(static_cast<const String*>(block->message)->data);
      drop_reference(*block);
    }
    return all;
  }
  /// The last writer that was made.
  [[nodiscard]] std::unique_ptr<ProxyReader> tap() { return broker.create_tap(made.back(), link, nullptr); }
  [[nodiscard]] EndpointSpec remote(const QoS& qos = QoS(10)) const {
    EndpointSpec out = spec(qos, "/remote");
    out.via = link;
    return out;
  }

  test::ManualClock clock;
  Broker broker{clock};
  std::vector<EndpointInfo> made;
  std::uint32_t link = broker.join(*this);
};

TEST_F(BrokerTap, hears_its_writer_only) {
  auto other = broker.create_writer(spec());
  auto writer = broker.create_writer(spec());
  auto heard = tap();
  send(*other, "other");
  send(*writer, "mine");
  EXPECT_EQ(receive(*heard), Texts{"mine"});
}

TEST_F(BrokerTap, is_no_subscription) {
  auto writer = broker.create_writer(spec());
  auto heard = tap();
  send(*writer, "x");
  EXPECT_EQ(writer->reader_count(), 0U);
  EXPECT_EQ(writer->status().matched_total, 0U);
  EXPECT_EQ(made.size(), 1U) << "no link is notified";
  std::vector<ReaderReport> readers;
  broker.report(readers);
  EXPECT_TRUE(readers.empty());
  EXPECT_EQ(broker.wiring("/chat", 1s).copies, 0U);
}

TEST_F(BrokerTap, gets_the_history_and_whatever_qos_its_writer_offers) {
  const QoS qos = QoS(2).transient_local().best_effort().deadline(1s);
  auto writer = broker.create_writer(spec(qos));
  for (const char* text : {"one", "two", "three"}) send(*writer, text);
  auto heard = tap();
  send(*writer, "four");
  EXPECT_EQ(receive(*heard), (Texts{"three", "four"})) << "two of history, of which the queue's depth leaves one";
}

TEST_F(BrokerTap, overwrites_where_a_keep_all_reader_would_refuse) {
  auto writer = broker.create_writer(spec(QoS(KeepAll{}).reliable().max_samples(2)));
  auto heard = tap();
  for (const char* text : {"one", "two", "three"}) {
    Block* const block = writer->borrow();
    static_cast<String*>(block->message)->data = text;
    EXPECT_EQ(writer->publish(*block), PublishResult::Published);
  }
  EXPECT_EQ(receive(*heard), (Texts{"two", "three"}));
  EXPECT_EQ(heard->counters().overwritten, 1U);
}

TEST_F(BrokerTap, outlives_its_writer_with_what_it_has) {
  auto writer = broker.create_writer(spec());
  auto heard = tap();
  send(*writer, "last words");
  writer.reset();
  EXPECT_EQ(receive(*heard), Texts{"last words"});
}

TEST_F(BrokerTap, of_a_writer_in_another_process_is_reported_to_that_process_only) {
  EndpointSpec there = spec();
  there.via = link;
  auto stand_in = broker.create_proxy_writer(there, 77);
  EndpointInfo writer = made.back();
  ASSERT_EQ(writer.id, 77U);
  made.clear();
  struct Deaf final : GraphListener {
    void on_made(const EndpointInfo& endpoint) noexcept override { told += endpoint.is_writer ? 0 : 1; }
    void on_gone(std::uint64_t) noexcept override {}
    void on_gate(std::uint64_t, bool) noexcept override {}
    void on_life(std::uint64_t) noexcept override {}
    void on_left(std::uint64_t) noexcept override {}
    int told = 0;
  } other;
  const std::uint32_t network = broker.join(other);
  auto heard = broker.create_tap(writer, network, nullptr);
  ASSERT_EQ(made.size(), 1U);
  EXPECT_FALSE(made[0].is_writer);
  EXPECT_EQ(other.told, 0);
  // What that process sends for it arrives.
  Block* const block = stand_in->borrow();
  static_cast<String*>(block->message)->data = "from afar";
  stand_in->relay(*block, {77, 1, clock.now(), {}}, kNeverExpires, std::vector<std::uint64_t>{made[0].id}, 0);
  EXPECT_EQ(receive(*heard), Texts{"from afar"});
  broker.leave(network);
}

TEST_F(BrokerTap, a_witness_is_counted_by_its_assigned_writers) {
  auto writer = broker.create_writer(spec(QoS(5).transient_local()));
  auto other = broker.create_writer(spec(QoS(5).transient_local()));
  const std::uint64_t id = made.front().id;
  made.clear();
  auto witness = broker.create_witness(remote(QoS(5).transient_local()));
  EXPECT_EQ(writer->reader_count(), 0U);
  witness->count_for(id, true);
  witness->count_for(id, true);
  EXPECT_EQ(writer->reader_count(), 1U);
  EXPECT_EQ(writer->status().matched_total, 1U);
  EXPECT_EQ(other->reader_count(), 0U);
  EXPECT_EQ(other->status().matched_total, 0U);
  EXPECT_TRUE(made.empty()) << "no link is notified";
  witness->count_for(id, false);
  EXPECT_EQ(writer->reader_count(), 0U);
  witness->count_for(id, true);
  witness.reset();
  EXPECT_EQ(writer->reader_count(), 0U);
}

TEST_F(BrokerTap, a_witness_gets_nothing) {
  auto writer = broker.create_writer(spec(QoS(5).transient_local()));
  auto witness = broker.create_witness(remote(QoS(5).transient_local()));
  witness->count_for(made.front().id, true);
  Block* const block = writer->borrow();
  EXPECT_EQ(writer->publish(*block), PublishResult::Published);
  std::vector<ReaderReport> readers;
  broker.report(readers);
  for (const auto& reader : readers) EXPECT_EQ(reader.waiting + reader.inactive + reader.delivered, 0U);
}

TEST_F(BrokerTap, reports_an_incompatible_witness_with_the_policy) {
  auto writer = broker.create_writer(spec(QoS(5).best_effort()));
  auto witness = broker.create_witness(remote(QoS(5).reliable()));
  EXPECT_EQ(writer->status().incompatible_qos, 1U);
  EXPECT_EQ(writer->status().last_policy, "reliability");
  EXPECT_NE(writer->status().last_clash.find("/remote"), std::string::npos);
}

TEST_F(BrokerTap, reports_an_endpoint_of_another_type_to_the_endpoint_concerned) {
  auto writer = broker.create_writer(spec());
  auto reader = broker.create_reader(spec(), Taking::Share, nullptr);
  auto other = broker.create_reader(spec(), Taking::Share, nullptr);
  const EndpointInfo writer_info = made[0], reader_info = made[1];
  broker.note_other_type(writer_info, "/remote", "std_msgs/msg/Header");
  broker.note_other_type(reader_info, "/sender", "std_msgs/msg/Header");
  EXPECT_EQ(writer->status().incompatible_type, 1U);
  EXPECT_EQ(reader->status().incompatible_type, 1U);
  EXPECT_EQ(other->status().incompatible_type, 0U);
  EXPECT_EQ(writer->status().last_policy, "type");
  EXPECT_EQ(writer->status().last_clash.rfind("/chat: /node publishes std_msgs/msg/String, /remote reads", 0), 0U);
  EXPECT_EQ(reader->status().last_clash.rfind("/chat: /sender publishes std_msgs/msg/Header, /node reads", 0), 0U);
  EXPECT_EQ(writer->status().matched, 2U) << "the others go on";
}

}  // namespace
}  // namespace nacelle::runtime
