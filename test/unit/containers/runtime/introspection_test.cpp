// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <future>
#include <std_srvs/srv/empty.hpp>
#include <std_srvs/srv/set_bool.hpp>
#include <thread>

#include "container_fixture.hpp"

namespace nacelle::runtime {
namespace {

using std_srvs::srv::SetBool;
using ::testing::HasSubstr;

/// A call of a SetBool, and its answer.
struct Asking {
  explicit Asking(Container& container, const std::string& service, bool data = true) {
    SetBool::Request request;
    request.data = data;
    auto sent = container.call_service(service, SetBool::service_type(), &request, [this] { answered.set_value(); });
    if (sent) {
      call = std::move(sent).value();
    } else {
      problem = sent.error().text();
    }
  }
  bool wait() { return answered.get_future().wait_for(20s) == std::future_status::ready; }
  std::promise<void> answered;
  std::unique_ptr<ServiceCall> call;
  std::string problem;
};

TEST_F(ContainerTest, a_service_is_called_from_outside_of_any_component) {
  bring_up(load("Talker", {{"word", std::string{"moo"}}}).id);
  Asking asking{container, "/talker/enable"};
  ASSERT_TRUE(asking.call) << asking.problem;
  ASSERT_TRUE(asking.wait());
  EXPECT_EQ(asking.call->state(), ServiceCall::State::Answered);
  const auto& response = *static_cast<const SetBool::Response*>(asking.call->response());
  EXPECT_TRUE(response.success);
  EXPECT_EQ(response.message, "moo");
}

TEST_F(ContainerTest, a_call_that_cannot_be_made_has_a_reason) {
  const auto talker = load("Talker");
  EXPECT_THAT(Asking(container, "/talker/enable").problem, HasSubstr("not active"));
  bring_up(talker.id);
  EXPECT_THAT(Asking(container, "/talker/enabel").problem, HasSubstr("did you mean '/talker/enable'"));
  std_srvs::srv::Empty::Request request;
  const auto wrong = container.call_service("/talker/enable", std_srvs::srv::Empty::service_type(), &request, [] {});
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().text(), HasSubstr("has the type std_srvs/srv/SetBool, not std_srvs/srv/Empty"));
}

TEST_F(ContainerTest, a_blocked_server_delays_no_other_and_its_late_answer_is_discarded) {
  std::array<int, 2> entered{}, release{};
  ASSERT_EQ(::pipe(entered.data()) + ::pipe(release.data()), 0);
  const auto sleeper = load("Sleeper", {{"sleep_in", std::string{"service"}},
                                        {"entered", std::int64_t{entered[1]}},
                                        {"release", std::int64_t{release[0]}}});
  bring_up(sleeper.id);
  char byte = 0;
  {
    Asking asking{container, "/sleeper/enable"};
    ASSERT_TRUE(asking.call);
    ASSERT_EQ(::read(entered[0], &byte, 1), 1);
    EXPECT_EQ(asking.call->state(), ServiceCall::State::Waiting);
    EXPECT_EQ(asking.call->response(), nullptr);
  }
  ASSERT_EQ(::write(release[1], &byte, 1), 1);
  // The first answer had no receiver any more; the next call has one.
  ASSERT_EQ(::write(release[1], &byte, 1), 1);
  Asking again{container, "/sleeper/enable"};
  ASSERT_TRUE(again.wait());
  EXPECT_EQ(static_cast<const SetBool::Response*>(again.call->response())->message, "well rested");
  for (const int fd : {entered[0], entered[1], release[0], release[1]}) ::close(fd);
}

struct ImpatientTest : ContainerTest {
  ImpatientTest() : ContainerTest(ContainerOptions{.transition_timeout = 100ms}) {}
};

TEST_F(ImpatientTest, calls_of_an_abandoned_server_are_refused) {
  std::array<int, 2> entered{}, release{};
  ASSERT_EQ(::pipe(entered.data()) + ::pipe(release.data()), 0);
  const auto sleeper = load("Sleeper", {{"sleep_in", std::string{"service"}},
                                        {"entered", std::int64_t{entered[1]}},
                                        {"release", std::int64_t{release[0]}}});
  bring_up(sleeper.id);
  Asking running{container, "/sleeper/enable"}, waiting{container, "/sleeper/enable"};
  char byte = 0;
  ASSERT_EQ(::read(entered[0], &byte, 1), 1);
  ASSERT_TRUE(container.unload(sleeper.id));
  ASSERT_TRUE(running.wait() && waiting.wait());
  EXPECT_EQ(running.call->state(), ServiceCall::State::Refused);
  EXPECT_EQ(waiting.call->state(), ServiceCall::State::Refused);
  ASSERT_EQ(::write(release[1], &byte, 1), 1);
  ASSERT_EQ(::write(release[1], &byte, 1), 1);  // a call that had begun already
  // What still runs when the container ends runs as long as the process, and other tests expect its library gone.
  const auto limit = std::chrono::steady_clock::now() + 20s;
  while (!container.kept_images().empty() && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
  EXPECT_TRUE(container.kept_images().empty());
  for (const int fd : {entered[0], entered[1], release[0], release[1]}) ::close(fd);
}

TEST_F(ContainerTest, lists_services_with_type_node_and_side) {
  load("Talker");
  load("Listener");
  const auto all = container.services();
  const auto find = [&](const std::string& node, bool is_server) {
    return std::ranges::find_if(all, [&](const auto& s) { return s.node == node && s.is_server == is_server; });
  };
  const auto server = find("/talker", true), client = find("/listener", false);
  ASSERT_TRUE(server != all.end() && client != all.end());
  EXPECT_EQ(server->name, "/talker/enable");
  EXPECT_EQ(server->type, "std_srvs/srv/SetBool");
  EXPECT_FALSE(server->open);
  EXPECT_EQ(client->name, "/talker/enable");
  EXPECT_TRUE(std::ranges::any_of(all, [](const auto& s) { return s.name == "/test/_container/list_nodes"; }));
}

TEST_F(ContainerTest, lists_endpoints_with_their_qos_but_not_those_of_tools) {
  load("Talker");
  EndpointSpec base{"/words", &String::message_type(), QoS(3).best_effort(), "/base"};
  base.command_timeout = {500ms, "timeout"};
  const auto reader = container.transport().create_reader(base, Taking::Share, nullptr);
  const auto tool =
      container.transport().create_reader({"/words", &String::message_type(), QoS(1), ""}, Taking::Share, nullptr);
  std::vector<EndpointReport> ends;
  for (auto& end : container.endpoints()) {
    if (end.topic == "/words") ends.push_back(std::move(end));
  }
  ASSERT_EQ(ends.size(), 2U);
  EXPECT_TRUE(ends[0].is_writer);
  EXPECT_EQ(ends[0].node + " " + ends[0].type, "/talker std_msgs/msg/String");
  EXPECT_EQ(ends[0].qos.durability(), Durability::TransientLocal);
  EXPECT_FALSE(ends[1].is_writer);
  EXPECT_EQ(ends[1].node, "/base");
  EXPECT_EQ(ends[1].qos.reliability(), Reliability::BestEffort);
  EXPECT_EQ(ends[1].qos.depth(), 3U);
  EXPECT_EQ(ends[1].command_timeout.after, Duration{500ms});
  EXPECT_EQ(ends[1].command_timeout.parameter, "timeout");
}

}  // namespace
}  // namespace nacelle::runtime
