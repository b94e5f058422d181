// SPDX-License-Identifier: Apache-2.0
#include "requests/request_server.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <functional>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "control/client.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/runtime/broker.hpp"

namespace nacelle::requests {
namespace {

using nlohmann::json;

class FakeRobot final : public Respondent {
 public:
  [[nodiscard]] const Clock& clock() const override { return clock_; }
  [[nodiscard]] Answer answer(const std::string& verb, const json&) override {
    if (verb == "memory") throw std::bad_alloc{};
    if (verb == "thread") throw std::system_error{EAGAIN, std::generic_category()};
    if (verb == "odd") throw 7;
    if (verb == "late") {
      auto late = std::make_unique<LateReply>();
      late->finish = finish;
      late->due = clock_.now() + 1h;
      late->bell->ring();
      return late;
    }
    return json{{"ok", true}, {"verb", verb}};
  }
  [[nodiscard]] Result<std::unique_ptr<TopicTap>, Problem> tap(const TapWish& wish) override {
    return std::make_unique<TopicTap>(broker_, wish.topic, std_msgs::msg::String::message_type(), 1);
  }
  [[nodiscard]] std::optional<Problem> problem_of(const std::string& topic) const override {
    return topic == "/forbidden" ? problem_ : std::nullopt;
  }
  void forbid() { problem_ = Problem{"/forbidden", "is not on the network", ""}; }
  [[nodiscard]] Transport& transport() { return broker_; }

  std::function<json()> finish = []() -> json { throw std::bad_alloc{}; };  ///< of a late answer

 private:
  const SystemClock clock_{};
  runtime::Broker broker_{clock_};
  std::optional<Problem> problem_;
};

class RequestServerTest : public ::testing::Test {
 protected:
  /// A guest whose first request it is; what the server says to it can be read.
  control::Client come(RequestServer& server, const std::string& verb) {
    std::array<int, 2> ends{-1, -1};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()), 0);
    auto connection = std::make_unique<control::Connection>(ends[1]);
    server.take({std::move(connection), json{{"verb", verb}}.dump()});
    return control::Client::over(ends[0], 0ns);
  }
  /// Returns the text of the next frame that the client receives: a reply or a fault.
  static std::string next_words(control::Client& client) {
    auto frame = client.receive(0ns);
    if (!frame) return "gone";
    if (!frame.value()) return "nothing";
    return std::string{as_text(frame.value()->payload)};
  }
  static void serve(RequestServer& server) {
    std::vector<pollfd> waits;
    server.append_waits(waits);
    for (const pollfd& wait : waits) EXPECT_GE(wait.fd, 0) << "each counts against the limit of the process";
    ASSERT_GE(::poll(waits.data(), waits.size(), 0), 0);
    server.serve(waits.data());
  }
  static bool holds(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

  FakeRobot robot_;
};

TEST_F(RequestServerTest, refuses_a_request_that_throws) {
  RequestServer server{robot_};
  const std::vector<std::pair<std::string, const char*>> refusals{
      {"memory", "out of memory"}, {"thread", "Resource temporarily unavailable"}, {"odd", "unknown exception"}};
  for (const auto& [verb, why] : refusals) {
    control::Client client = come(server, verb);
    const std::string refusal = next_words(client);
    EXPECT_TRUE(holds(refusal, why) && holds(refusal, "the container keeps running")) << refusal;
    ASSERT_TRUE(client.send(control::FrameKind::Request, R"({"verb":"good"})"));
    serve(server);
    EXPECT_TRUE(holds(next_words(client), "good")) << "the connection goes on after " << verb;
  }
}

TEST_F(RequestServerTest, closes_only_the_connection_whose_late_answer_throws) {
  RequestServer server{robot_};
  control::Client unlucky = come(server, "late"), other = come(server, "good");
  serve(server);
  EXPECT_TRUE(holds(next_words(unlucky), "out of memory"));
  EXPECT_EQ(next_words(unlucky), "gone");
  EXPECT_TRUE(holds(next_words(other), "good"));
}

TEST_F(RequestServerTest, sends_messages_ahead_of_an_answer_that_came_after_them) {
  RequestServer server{robot_};
  // The one that is answered came first, as `nacelle action send_goal` does.
  control::Client asking = come(server, "good"), listening = come(server, "good");
  next_words(asking);
  next_words(listening);
  ASSERT_TRUE(listening.send(control::FrameKind::Request, R"({"verb":"topic.listen","topic":"/feedback"})"));
  serve(server);
  ASSERT_TRUE(holds(next_words(listening), "std_msgs/msg/String"));
  auto writer =
      robot_.transport().create_writer({"/feedback", &std_msgs::msg::String::message_type(), QoS{1}, "/node"});
  std::string heard;
  robot_.finish = [&]() -> json {
    heard = next_words(listening);
    return json{{"ok", true}};
  };
  ASSERT_TRUE(asking.send(control::FrameKind::Request, R"({"verb":"late"})"));
  serve(server);  // reads the request
  Block* const block = writer->borrow();
  static_cast<std_msgs::msg::String*>(block->message)->data = "almost there";
  writer->publish(*block);
  serve(server);
  EXPECT_TRUE(holds(heard, "almost there")) << heard;
}

TEST_F(RequestServerTest, serves_no_client_from_an_outdated_list_of_waits) {
  RequestServer server{robot_};
  control::Client client = come(server, "good");
  EXPECT_TRUE(holds(next_words(client), "good"));
  ASSERT_TRUE(client.send(control::FrameKind::Request, R"({"verb":"better"})"));
  server.serve(nullptr);  // append_waits() had no memory
  EXPECT_EQ(next_words(client), "nothing");
  serve(server);
  EXPECT_TRUE(holds(next_words(client), "better"));
}

TEST_F(RequestServerTest, bounds_pending_requests_and_names_the_reason) {
  RequestServer server{robot_, {.guests = 3}};
  std::vector<control::Client> waiting;
  for (int i = 0; i < 3; ++i) waiting.push_back(come(server, "late"));
  control::Client fourth = come(server, "good");
  EXPECT_TRUE(holds(next_words(fourth), "all 3 connections for requests are in use"));
  EXPECT_EQ(next_words(fourth), "gone");
}

TEST_F(RequestServerTest, closes_the_longest_idle_connection_for_a_new_one) {
  RequestServer server{robot_, {.guests = 2, .makes_room_after = 0ns}};
  control::Client first = come(server, "one"), second = come(server, "two");
  control::Client third = come(server, "three");
  EXPECT_TRUE(holds(next_words(third), "three"));
  EXPECT_TRUE(holds(next_words(first), "one"));
  EXPECT_TRUE(holds(next_words(first), "closed as the longest idle connection"));
  EXPECT_TRUE(holds(next_words(second), "two"));
  EXPECT_EQ(next_words(second), "nothing") << "it stays";
}

TEST_F(RequestServerTest, ends_listening_to_a_topic_that_turns_out_to_be_unreachable) {
  RequestServer server{robot_};
  control::Client listener = come(server, "good"), other = come(server, "good");
  for (auto& [client, topic] : {std::pair{&listener, "/forbidden"}, {&other, "/open"}}) {
    next_words(*client);
    ASSERT_TRUE(client->send(control::FrameKind::Request, json{{"verb", "topic.listen"}, {"topic", topic}}.dump()));
  }
  serve(server);
  EXPECT_TRUE(holds(next_words(listener), "std_msgs/msg/String"));
  EXPECT_TRUE(holds(next_words(other), "std_msgs/msg/String"));
  EXPECT_EQ(next_words(listener), "nothing");
  robot_.forbid();
  serve(server);
  EXPECT_EQ(next_words(listener), "/forbidden: is not on the network");
  EXPECT_EQ(next_words(listener), "gone");
  EXPECT_EQ(next_words(other), "nothing");
}

TEST_F(RequestServerTest, closes_idle_connections) {
  RequestServer server{robot_, {.idle = 0ns}};
  control::Client client = come(server, "good");
  ASSERT_TRUE(server.next_due());
  EXPECT_LE(*server.next_due(), robot_.clock().now());
  serve(server);
  EXPECT_TRUE(holds(next_words(client), "good"));
  EXPECT_TRUE(holds(next_words(client), "idle for too long"));
  EXPECT_FALSE(server.next_due());
}

TEST_F(RequestServerTest, closes_the_newer_half_with_the_reason) {
  RequestServer server{robot_};
  control::Client first = come(server, "one"), second = come(server, "two");
  server.send_half_away("too many");
  EXPECT_TRUE(holds(next_words(second), "two"));
  EXPECT_EQ(next_words(second), "too many");
  EXPECT_TRUE(holds(next_words(first), "one"));
  EXPECT_EQ(next_words(first), "nothing");
}

}  // namespace
}  // namespace nacelle::requests
