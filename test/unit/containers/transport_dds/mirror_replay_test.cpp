// SPDX-License-Identifier: Apache-2.0
// What ROS 2 was heard to ask is answered with the bytes that it was heard to answer.
#include <gtest/gtest.h>

#include <lifecycle_msgs/srv/change_state.hpp>
#include <lifecycle_msgs/srv/get_available_transitions.hpp>
#include <lifecycle_msgs/srv/get_state.hpp>

#include "mirrored_container.hpp"
#include "recordings.hpp"

namespace nacelle {
namespace {

using lifecycle_msgs::srv::GetState;
using test::MirroredContainer;
using test::Offering;
using test::RawEnd;

/// The first recorded reply of this service with the request that it answers, if that was recorded.
struct Exchange {
  Bytes request, reply;
};
template <typename S>
Exchange recorded_exchange(const std::string& recording, const std::string& service, std::size_t number) {
  using transport_dds::read_call;
  Bytes scratch;
  std::vector<Exchange> all;
  const auto samples = transport_dds::recorded::samples(recording);
  for (const auto& asked : samples) {
    if (asked.topic != "rq" + service + "Request") continue;
    for (const auto& reply : samples) {
      if (reply.topic != "rr" + service + "Reply") continue;
      const auto header = read_call(asked.payload, scratch)->header;
      if (!(read_call(reply.payload, scratch)->header == header)) continue;
      const bool known =
          std::any_of(all.begin(), all.end(), [&](const Exchange& e) { return e.request == asked.payload; });
      if (!known) all.push_back({asked.payload, reply.payload});
    }
  }
  EXPECT_GT(all.size(), number) << service;
  return all.size() > number ? all[number] : Exchange{};
}

template <typename S>
void replay(const std::string& recording, const std::string& service, std::size_t number) {
  const Exchange exchange = recorded_exchange<S>(recording, service, number);
  ASSERT_FALSE(exchange.reply.empty());
  Bytes scratch;
  typename S::Request expected;
  typename S::Response response;
  ASSERT_TRUE(msgs::from_cdr(transport_dds::read_call(exchange.request, scratch)->message, expected));
  ASSERT_TRUE(msgs::from_cdr(transport_dds::read_call(exchange.reply, scratch)->message, response));
  std::atomic<bool> is_as_recorded{false};
  Offering<S> offering{service, [&](const typename S::Request& asked, typename S::Response& answer) {
                         is_as_recorded = asked == expected;
                         answer = response;
                       }};
  MirroredContainer there{"there"};
  there.load(offering, "offering");
  const auto participant = test::make_participant();
  RawEnd client{*participant, S::Request::message_type(),         S::Response::message_type(), service,
                false,        " 1.10.0.0.0.0.0.0.0.0.0.0.0.0.0.1"};
  client.make_reply_reader();
  ASSERT_TRUE(client.matched());
  client.say(exchange.request);
  Bytes written = client.next();
  EXPECT_TRUE(is_as_recorded) << service;
  // Both may be padded to four bytes.
  Bytes reply = exchange.reply;
  reply.resize((reply.size() + 3) / 4 * 4);
  written.resize((written.size() + 3) / 4 * 4);
  EXPECT_EQ(to_hex(written), to_hex(reply)) << service;
}

TEST(MirrorReplay, of_recorded_requests_has_the_recorded_replies) {
  replay<GetState>("lc", "/lc_talker/get_state", 0);
  replay<GetState>("lc", "/lc_talker/get_state", 1);
  replay<lifecycle_msgs::srv::GetAvailableTransitions>("lc", "/lc_talker/get_available_transitions", 0);
  replay<lifecycle_msgs::srv::ChangeState>("lc", "/lc_talker/change_state", 0);
}

}  // namespace
}  // namespace nacelle
