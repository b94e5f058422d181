// SPDX-License-Identifier: Apache-2.0
#include "remote/service_clients.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <std_srvs/srv/set_bool.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <vector>

namespace nacelle::remote {
namespace {

using std_srvs::srv::SetBool;
using std_srvs::srv::Trigger;

/// A network with one server, which keeps its calls.
struct FakeNetwork final : ServiceListener, RemoteServer {
  void on_made(const ServiceEndInfo& end) noexcept override { made.push_back(end); }
  void on_gone(std::uint64_t) noexcept override {}
  bool take(Call call) noexcept override {
    if (is_full) return false;
    calls.push_back(std::move(call));
    return true;
  }
  std::vector<ServiceEndInfo> made;
  std::vector<Call> calls;
  bool is_full = false;
};

struct ServiceClientsTest : ::testing::Test {
  ServiceClientsTest() { clients.join(network); }
  ~ServiceClientsTest() override { clients.leave(network); }
  [[nodiscard]] std::uint64_t client() { return clients.client_of("/enable", SetBool::service_type()); }
  int changes = 0;
  FakeNetwork network;
  ServiceClients clients{"/tool", [this] { ++changes; }};
};

TEST_F(ServiceClientsTest, tells_the_network_of_each_service_once) {
  const std::uint64_t first = client(), again = client();
  const std::uint64_t other = clients.client_of("/enable", Trigger::service_type());

  EXPECT_EQ(first, again);
  EXPECT_NE(first, other);
  ASSERT_EQ(network.made.size(), 2U);
  EXPECT_EQ(network.made[0].node, "/tool");
  EXPECT_EQ(network.made[0].name, "/enable");
  EXPECT_FALSE(network.made[0].is_server);
}

TEST_F(ServiceClientsTest, reports_existing_services_to_a_late_listener) {
  static_cast<void>(client());
  FakeNetwork late;

  clients.join(late);
  clients.leave(late);

  EXPECT_EQ(late.made.size(), 1U);
}

TEST_F(ServiceClientsTest, is_ready_while_the_network_has_a_server) {
  const std::uint64_t id = client();
  EXPECT_FALSE(clients.is_ready(id));

  clients.set_remote(id, &network);
  EXPECT_TRUE(clients.is_ready(id));
  clients.set_remote(id, nullptr);

  EXPECT_FALSE(clients.is_ready(id));
  EXPECT_EQ(changes, 2);
}

TEST_F(ServiceClientsTest, hands_a_call_over_only_to_a_server_that_takes_it) {
  const std::uint64_t id = client();
  RemoteCall call{[] {}};
  const auto request = [&] { return Call{call.asker(), msgs::AnyMessage{SetBool::Request::message_type()}}; };
  EXPECT_FALSE(clients.call(id, request()));

  clients.set_remote(id, &network);
  EXPECT_TRUE(clients.call(id, request()));
  network.is_full = true;
  EXPECT_FALSE(clients.call(id, request()));

  EXPECT_EQ(network.calls.size(), 1U);
}

TEST(RemoteCall, keeps_its_answer_and_reports_it_once) {
  int told = 0;
  RemoteCall call{[&] { ++told; }};
  EXPECT_EQ(call.state(), runtime::ServiceCall::State::Waiting);
  EXPECT_EQ(call.response(), nullptr);

  auto response = std::make_unique<msgs::AnyMessage>(Trigger::Response::message_type());
  static_cast<Trigger::Response*>(response->get())->message = "done";
  EXPECT_TRUE(call.asker().answer(std::move(response)));

  EXPECT_EQ(call.state(), runtime::ServiceCall::State::Answered);
  EXPECT_EQ(static_cast<const Trigger::Response*>(call.response())->message, "done");
  EXPECT_EQ(told, 1);
}

TEST(RemoteCall, is_refused_where_there_will_be_no_answer) {
  RemoteCall call{[] {}};

  EXPECT_TRUE(call.asker().answer(nullptr));

  EXPECT_EQ(call.state(), runtime::ServiceCall::State::Refused);
  EXPECT_EQ(call.response(), nullptr);
}

TEST(RemoteCall, is_not_reached_after_its_end) {
  std::optional<RemoteCall> call;
  call.emplace([] { ADD_FAILURE() << "the call has ended"; });
  const Asker asker = call->asker();

  call.reset();

  EXPECT_FALSE(asker.answer(nullptr));
}

}  // namespace
}  // namespace nacelle::remote
