// SPDX-License-Identifier: Apache-2.0
// Services over links that are pumped by hand: the container's directory on one side, those of its isolated processes on the others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <functional>
#include <std_msgs/msg/header.hpp>
#include <std_msgs/msg/string.hpp>

#include "runtime/src/services.hpp"
#include "support/linked_brokers.hpp"
#include "support/manual_clock.hpp"
#include "transport_local/wire/frame.hpp"

namespace nacelle {
namespace {

using runtime::ServiceDirectory;
using std_msgs::msg::String;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::size_t kMostCalls = 256;
const msgs::MessageType& kType = String::message_type();

msgs::AnyMessage message_of(const std::string& text) {
  msgs::AnyMessage message{kType};
  static_cast<String*>(message.get())->data = text;
  return message;
}

/// A server, or the network behind a client, whose answers the test gives.
struct Server final : RemoteServer {
  [[nodiscard]] bool take(Call call) noexcept override {
    requests.push_back(static_cast<const String*>(call.request.get())->data);
    askers.push_back(call.asker);
    return true;
  }
  void answer(std::size_t call, const std::string& text) const {
    EXPECT_TRUE(askers.at(call).answer(std::make_unique<msgs::AnyMessage>(message_of(text))));
  }
  std::vector<std::string> requests;
  std::vector<Asker> askers;
};

/// Waits for answers and writes them down.
struct Caller final : AnswerTaker {
  ~Caller() override { *self->lock() = nullptr; }
  void push(std::int64_t sequence, std::unique_ptr<msgs::AnyMessage> response) override {
    answers.push_back(std::to_string(sequence) + ": " +
                      (response ? static_cast<const String*>(response->get())->data : "none"));
  }
  [[nodiscard]] bool call(ServiceDirectory& directory, const std::string& text, std::uint64_t client = 0) {
    return directory.send("/echo", kType, {{self, ++last}, message_of(text)}, client);
  }
  std::int64_t last = 0;
  std::vector<std::string> answers;
  std::shared_ptr<Guarded<AnswerTaker*>> self =
      std::make_shared<Guarded<AnswerTaker*>>(std::in_place, static_cast<AnswerTaker*>(this));
};

ServiceEndInfo end_of(const std::string& node, bool is_server, bool is_open = true) {
  return {0, is_server, "/echo", node, &kType, &kType, is_open};
}

/// Writes down the ids of clients.
struct Clients final : ServiceListener {
  void on_made(const ServiceEndInfo& end) noexcept override {
    if (!end.is_server) ids.push_back(end.id);
  }
  void on_gone(std::uint64_t id) noexcept override { std::erase(ids, id); }
  std::vector<std::uint64_t> ids;
};

/// An isolated process, joined to a container's directory.
struct Child {
  Child(const Clock& clock, ServiceDirectory& hub)
      : far_broker(clock),
        near_broker(clock),
        far_link(std::make_unique<Link>(far_broker, clock, sockets.one, options([&](LinkOptions& options) {
                                          options.services = &services;
                                          options.private_node = "/private";
                                        }))),
        near_link(std::make_unique<Link>(near_broker, clock, sockets.two,
                                         options([&](LinkOptions& options) { options.service_hub = &hub; }))) {}
  static LinkOptions options(const std::function<void(LinkOptions&)>& change) {
    LinkOptions options;
    options.peer = "the peer";
    options.find_type = test::find_test_type;
    change(options);
    return options;
  }
  bool pump() const {
    const bool far = far_link && far_link->pump();
    return (near_link && near_link->pump()) || far;
  }

  ServiceDirectory services;
  runtime::Broker far_broker, near_broker;
  test::SocketPair sockets;
  std::unique_ptr<Link> far_link, near_link;
};

class LinkServicesTest : public ::testing::Test {
 protected:
  void settle() const {
    while (child_.pump() || other_.pump()) {}
  }
  /// The child's server; closed if its node is not active.
  std::uint64_t offer(bool is_open = true) {
    const auto id = child_.services.add_stand_in(end_of("/child", true, is_open), &server_);
    settle();
    return id;
  }

  test::ManualClock clock_;
  ServiceDirectory hub_;
  Server server_;
  Caller caller_;
  Child child_{clock_, hub_}, other_{clock_, hub_};
};

TEST_F(LinkServicesTest, the_container_calls_a_server_of_the_process) {
  offer();
  ASSERT_TRUE(caller_.call(hub_, "hello"));
  settle();
  ASSERT_THAT(server_.requests, ElementsAre("hello"));
  EXPECT_THAT(caller_.answers, IsEmpty());
  server_.answer(0, "olleh");
  settle();
  EXPECT_THAT(caller_.answers, ElementsAre("1: olleh"));

  std::vector<runtime::ServiceReport> reports;
  hub_.report_stand_ins(reports);
  ASSERT_EQ(reports.size(), 1U);
  EXPECT_EQ(reports[0].name, "/echo");
  EXPECT_EQ(reports[0].node, "/child");
  EXPECT_TRUE(reports[0].is_server && reports[0].open && !reports[0].is_standard);
}

TEST_F(LinkServicesTest, a_client_of_the_process_calls_a_server_of_the_container) {
  const auto client = child_.services.add_client(end_of("/child", false));
  settle();
  EXPECT_FALSE(child_.services.is_ready("/echo", kType, client));
  EXPECT_FALSE(caller_.call(child_.services, "early", client));

  const auto here = hub_.add_stand_in(end_of("/near", true), &server_);
  settle();
  EXPECT_TRUE(child_.services.is_ready("/echo", kType, client));
  ASSERT_TRUE(caller_.call(child_.services, "hello", client));
  settle();
  ASSERT_THAT(server_.requests, ElementsAre("hello"));
  server_.answer(0, "olleh");
  settle();
  EXPECT_THAT(caller_.answers, ElementsAre("2: olleh"));

  hub_.remove_stand_in(here);
  settle();
  EXPECT_FALSE(child_.services.is_ready("/echo", kType, client));
}

TEST_F(LinkServicesTest, a_client_of_the_process_reaches_what_another_link_offers_to_its_stand_in) {
  Clients clients;
  hub_.join(clients);
  const auto client = child_.services.add_client(end_of("/child", false));
  settle();
  ASSERT_EQ(clients.ids.size(), 1U);
  hub_.set_remote(clients.ids[0], &server_);
  settle();
  ASSERT_TRUE(child_.services.is_ready("/echo", kType, client));
  ASSERT_TRUE(caller_.call(child_.services, "hello", client));
  settle();
  ASSERT_EQ(server_.askers.size(), 1U);
  server_.answer(0, "from the network");
  settle();
  EXPECT_THAT(caller_.answers, ElementsAre("1: from the network"));

  hub_.set_remote(clients.ids[0], nullptr);
  settle();
  EXPECT_FALSE(child_.services.is_ready("/echo", kType, client));
  child_.services.remove_client(client);
  settle();
  EXPECT_THAT(clients.ids, IsEmpty());
  hub_.leave(clients);
}

TEST_F(LinkServicesTest, two_processes_call_each_other_through_the_container) {
  const auto client = other_.services.add_client(end_of("/other", false));
  offer();
  ASSERT_TRUE(caller_.call(other_.services, "hello", client));
  settle();
  ASSERT_THAT(server_.requests, ElementsAre("hello"));
  server_.answer(0, "olleh");
  settle();
  EXPECT_THAT(caller_.answers, ElementsAre("1: olleh"));
}

TEST_F(LinkServicesTest, a_server_whose_node_is_not_active_is_not_ready) {
  const auto id = offer(false);
  EXPECT_FALSE(hub_.is_ready("/echo"));
  EXPECT_FALSE(caller_.call(hub_, "early"));
  EXPECT_THAT(hub_.why_not("/echo", kType).what, HasSubstr("not active"));
  child_.services.open_stand_in(id, true);
  settle();
  EXPECT_TRUE(hub_.is_ready("/echo"));
  child_.services.open_stand_in(id, false);
  EXPECT_TRUE(caller_.call(hub_, "too late")) << "the container does not know yet";
  settle();
  EXPECT_THAT(caller_.answers, ElementsAre("2: none"));
  EXPECT_FALSE(hub_.is_ready("/echo"));
}

TEST_F(LinkServicesTest, calls_fail_when_the_process_ends) {
  offer();
  ASSERT_TRUE(caller_.call(hub_, "sent"));
  settle();
  ASSERT_TRUE(caller_.call(hub_, "waits to be sent"));
  child_.far_link.reset();
  settle();
  EXPECT_THAT(caller_.answers, testing::UnorderedElementsAre("1: none", "2: none"));
  EXPECT_FALSE(hub_.is_ready("/echo"));
  EXPECT_FALSE(caller_.call(hub_, "late"));
  EXPECT_FALSE(server_.askers[0].answer(nullptr)) << "its link has gone";
}

TEST_F(LinkServicesTest, calls_of_the_process_fail_when_its_link_ends) {
  const auto client = child_.services.add_client(end_of("/child", false));
  const auto here = hub_.add_stand_in(end_of("/near", true), &server_);
  settle();
  ASSERT_TRUE(caller_.call(child_.services, "hello", client));
  settle();
  child_.near_link.reset();
  settle();
  EXPECT_THAT(caller_.answers, ElementsAre("1: none"));
  EXPECT_FALSE(child_.services.is_ready("/echo", kType, client));
  hub_.remove_stand_in(here);
}

TEST_F(LinkServicesTest, a_last_answer_arrives_before_its_server_goes) {
  const auto id = offer();
  ASSERT_TRUE(caller_.call(hub_, "one") && caller_.call(hub_, "two"));
  settle();
  server_.answer(0, "last");
  child_.services.remove_stand_in(id);
  EXPECT_TRUE(server_.askers[1].answer(nullptr));
  settle();
  EXPECT_THAT(caller_.answers, ElementsAre("1: last", "2: none"));
  EXPECT_FALSE(hub_.is_ready("/echo"));
}

TEST_F(LinkServicesTest, refuses_calls_beyond_the_limit_until_some_are_answered) {
  offer();
  for (std::size_t i = 0; i < kMostCalls; ++i) ASSERT_TRUE(caller_.call(hub_, "x"));
  EXPECT_FALSE(caller_.call(hub_, "too many"));
  EXPECT_THAT(hub_.why_not("/echo", kType).what, HasSubstr("no more calls"));
  settle();
  EXPECT_FALSE(caller_.call(hub_, "still too many"));
  server_.answer(0, "y");
  settle();
  EXPECT_TRUE(caller_.call(hub_, "one more"));
}

TEST_F(LinkServicesTest, callers_that_no_longer_wait_leave_room) {
  offer();
  {
    Caller impatient;
    for (std::size_t i = 0; i + 1 < kMostCalls; ++i) ASSERT_TRUE(impatient.call(hub_, "x"));
    settle();
  }
  EXPECT_TRUE(caller_.call(hub_, "the last one"));
  settle();
  EXPECT_TRUE(caller_.call(hub_, "one more"));
}

TEST_F(LinkServicesTest, refuses_what_is_too_long) {
  offer();
  const std::string longest(transport_local::kLongestServiceBytes, 'x');
  EXPECT_FALSE(caller_.call(hub_, longest));
  ASSERT_TRUE(caller_.call(hub_, "short"));
  settle();
  server_.answer(0, longest);
  settle();
  EXPECT_THAT(caller_.answers, ElementsAre("2: none"));
  EXPECT_FALSE(child_.near_link->has_ended());
}

TEST_F(LinkServicesTest, bounds_what_waits_to_be_sent) {
  offer();
  const std::string text(transport_local::kLongestServiceBytes / 2, 'x');
  int taken = 0;
  while (taken < 100 && caller_.call(hub_, text)) ++taken;
  EXPECT_EQ(taken, 7) << "of 8 MiB and a header each, 64 MiB at most";
  settle();
  EXPECT_EQ(server_.requests.size(), 7U);
  EXPECT_TRUE(caller_.call(hub_, text));
}

TEST_F(LinkServicesTest, keeps_the_services_of_the_processs_own_node_to_itself) {
  Server own;
  static_cast<void>(child_.services.add_stand_in(end_of("/private", true), &own));
  settle();
  EXPECT_FALSE(hub_.is_ready("/echo"));
}

// --- a peer of bytes ----------------------------------------------------------------------------------------------------

class HostileServicesTest : public ::testing::Test {
 protected:
  HostileServicesTest()
      : link_(broker_, clock_, sockets_.one,
              Child::options([this](LinkOptions& options) { options.service_hub = &hub_; })) {
    say([](Bytes& out) { transport_local::append_hello(out, ""); });
  }
  ~HostileServicesTest() override { ::close(sockets_.two); }
  void say(const std::function<void(Bytes&)>& append) {
    Bytes bytes;
    append(bytes);
    ASSERT_EQ(::send(sockets_.two, bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
    while (link_.pump()) {}
  }
  void announce(const transport_local::ServiceFrame& service) {
    say([&](Bytes& out) { transport_local::append_service(out, service); });
  }
  void call(std::uint64_t end, std::uint64_t number, const std::string& cdr) {
    say([&](Bytes& out) {
      std::uint8_t* const at = transport_local::append_call(out, end, number, cdr.size());
      std::copy(cdr.begin(), cdr.end(), at);
    });
  }
  /// What the link has answered since the last time: "number" of each call that gets no answer.
  std::vector<std::uint64_t> refusals() {
    Bytes bytes(1U << 16U);
    const ssize_t n = ::recv(sockets_.two, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (n > 0) {
      std::copy_n(bytes.begin(), n, frames_.room().begin());
      frames_.filled(static_cast<std::size_t>(n));
    }
    std::vector<std::uint64_t> numbers;
    for (auto next = frames_.next(); next && next.value(); next = frames_.next()) {
      if (next.value()->kind != transport_local::LinkFrameKind::Answer) continue;
      const auto answer = transport_local::read_answer(next.value()->payload);
      if (answer && !answer->answered) numbers.push_back(answer->number);
    }
    return numbers;
  }
  static transport_local::ServiceFrame service(std::uint64_t id, bool is_server) {
    return {id, is_server, true, "/echo", "/far", kType.name, kType.hash, kType.name, kType.hash};
  }

  test::ManualClock clock_;
  runtime::Broker broker_{clock_};
  ServiceDirectory hub_;
  test::SocketPair sockets_;
  transport_local::LinkFrameReader frames_;
  Link link_;
};

TEST_F(HostileServicesTest, an_id_that_is_taken_ends_the_link) {
  announce(service(7, true));
  EXPECT_TRUE(hub_.is_ready("/echo"));
  announce(service(7, false));
  EXPECT_TRUE(link_.has_ended());
  EXPECT_FALSE(hub_.is_ready("/echo"));
}

TEST_F(HostileServicesTest, a_service_of_another_definition_or_a_bad_name_is_not_linked) {
  auto other = service(7, true);
  other.request_hash = "RIHS01_other";
  announce(other);
  auto unknown = service(8, true);
  unknown.response = "unknown_msgs/srv/Missing_Response";
  announce(unknown);
  auto bad = service(9, true);
  bad.name = "not a name";
  announce(bad);
  EXPECT_FALSE(hub_.is_ready("/echo"));
  EXPECT_FALSE(link_.has_ended());
  call(7, 1, "");
  EXPECT_THAT(refusals(), ElementsAre(1U));
}

TEST_F(HostileServicesTest, calls_that_cannot_be_are_answered_with_none_and_counted) {
  announce(service(7, false));
  announce(service(8, true));
  const std::string cdr{"\0\1\0\0\2\0\0\0x\0", 10};
  call(99, 1, cdr);  // no such client
  call(8, 2, cdr);   // a server sends no calls
  EXPECT_EQ(link_.stats().dropped, 2U);
  call(7, 3, "garbage");
  EXPECT_EQ(link_.stats().broken, 1U);
  EXPECT_THAT(refusals(), ElementsAre(1U, 2U, 3U));
  say([](Bytes& out) { transport_local::append_no_answer(out, 4711); });  // of no call
  EXPECT_EQ(link_.stats().dropped, 3U);
  EXPECT_FALSE(link_.has_ended());
}

TEST_F(HostileServicesTest, more_calls_than_the_limit_are_refused) {
  Server server;
  static_cast<void>(hub_.add_stand_in({0, true, "/other", "/near", &kType, &kType}, &server));
  auto client = service(7, false);
  client.name = "/other";
  announce(client);
  const std::string cdr{"\0\1\0\0\2\0\0\0x\0", 10};
  for (std::uint64_t i = 1; i <= kMostCalls + 2; ++i) call(7, i, cdr);
  EXPECT_EQ(server.requests.size(), kMostCalls);
  EXPECT_THAT(refusals(), ElementsAre(kMostCalls + 1, kMostCalls + 2));
}

TEST_F(HostileServicesTest, an_answer_that_is_no_response_fails_the_call) {
  announce(service(7, true));
  Caller caller;
  ASSERT_TRUE(caller.call(hub_, "hello"));
  while (link_.pump()) {}
  say([](Bytes& out) {
    const std::string text = "garbage";
    std::uint8_t* const at = transport_local::append_answer(out, 1, text.size());
    std::copy(text.begin(), text.end(), at);
  });
  EXPECT_THAT(caller.answers, ElementsAre("1: none"));
  EXPECT_EQ(link_.stats().broken, 1U);
}

}  // namespace
}  // namespace nacelle
