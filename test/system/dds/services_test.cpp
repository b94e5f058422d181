// SPDX-License-Identifier: Apache-2.0
// A container's services and calls against programs that have nothing of Nacelle in them. Both vendors' peers write
// rmw_cyclonedds's header; rmw_fastrtps does not, which mirror_hostile_services_test.cpp is about.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <example_interfaces/srv/add_two_ints.hpp>
#include <map>
#include <string>

#include "support/peer_process.hpp"
#include "support/places.hpp"
#include "unit/containers/transport_dds/mirrored_container.hpp"

namespace nacelle {
namespace {

using example_interfaces::srv::AddTwoInts;
using test::PeerProcess;

const std::map<std::string, std::string> kServicePeers{
    {"cyclone", test::built("test/peers/cyclone_peer")},
#ifdef NACELLE_HAS_FASTDDS_PEER
    {"fastdds", test::built("test/peers/fastdds_peer")},
#endif
};

std::vector<std::string> vendors_of_services() {
  std::vector<std::string> out;
  out.reserve(kServicePeers.size());
  for (const auto& [vendor, program] : kServicePeers) out.push_back(vendor);
  return out;
}

class ServicePeer : public ::testing::TestWithParam<std::string> {
 public:
  [[nodiscard]] std::unique_ptr<PeerProcess> start(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--topic", "add_two_ints", "--domain", std::to_string(test::test_domain())});
    const std::string config =
        test::loopback_config(test::test_domain()) + "<Discovery><LeaseDuration>5s</LeaseDuration></Discovery>";
    auto peer = std::make_unique<PeerProcess>(
        kServicePeers.at(GetParam()), arguments,
        std::map<std::string, std::string>{{"CYCLONEDDS_URI", config}, {"NACELLE_PEER_LEASE_S", "5"}});
    EXPECT_EQ(peer->line(), "ready");
    return peer;
  }
  [[nodiscard]] bool knows_both_ends() {
    return here.bell.until([&] {
      std::size_t ends = 0;
      here.mirror->look(
          [&](const transport_dds::RemoteGraph& graph) { ends = graph.ends_of_service("/add_two_ints").size(); });
      return ends == 2;
    });
  }

  test::Offering<AddTwoInts> adding{"/add_two_ints",
                                    [](const auto& request, auto& response) { response.sum = request.a + request.b; }};
  test::Calling<AddTwoInts> calling{"/add_two_ints"};
  test::MirroredContainer here{"here"};
};
INSTANTIATE_TEST_SUITE_P(Peers, ServicePeer, ::testing::ValuesIn(vendors_of_services()),
                         [](const auto& vendor) { return vendor.param; });

TEST_P(ServicePeer, calls_a_service_of_this_container) {
  here.load(adding, "adder");
  const auto peer = start({"call", "--a", "40", "--b", "-2"});
  ASSERT_TRUE(knows_both_ends());
  peer->go();
  EXPECT_EQ(peer->line(), "sum 38");
  EXPECT_EQ(peer->end(), 0);
  EXPECT_TRUE(here.bell.until([&] { return here.stats().replies == 1; })) << "counted when it is gone";
}

TEST_P(ServicePeer, serves_a_client_of_this_container) {
  here.load(calling, "caller");
  const auto peer = start({"serve", "--count", "2"});
  ASSERT_TRUE(here.bell.until([&] { return calling.client->service_is_ready(); }));
  peer->go();
  ASSERT_EQ(peer->line(), "met");
  for (std::int64_t b : {4, 5}) {
    AddTwoInts::Request request;
    request.a = 3;
    request.b = b;
    const auto answer = calling.call(request);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->sum, 3 + b);
    EXPECT_EQ(peer->line(), "served 3 " + std::to_string(b));
  }
}

TEST_P(ServicePeer, that_dies_keeps_no_caller_waiting) {
  here.load(calling, "caller");
  const auto peer = start({"serve"});
  ASSERT_TRUE(here.bell.until([&] { return calling.client->service_is_ready(); }));
  peer->stop();
  auto pending = calling.client->async_send_request(AddTwoInts::Request{});
  ASSERT_TRUE(here.bell.until([&] { return here.stats().calls == 1; }));
  peer->kill_hard();
  EXPECT_EQ(calling.answer_to(std::move(pending)), nullptr) << "the call fails when the lease has expired";
  EXPECT_FALSE(calling.client->service_is_ready());
}

}  // namespace
}  // namespace nacelle
