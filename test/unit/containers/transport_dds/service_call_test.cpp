// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/service_call.hpp"

#include <gtest/gtest.h>

#include <lifecycle_msgs/srv/get_state.hpp>
#include <set>

#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "recordings.hpp"
#include "support/places.hpp"
#include "transport_dds/wire/names.hpp"

namespace nacelle::transport_dds {
namespace {

using Response = lifecycle_msgs::srv::GetState::Response;

Response active() {
  Response response;
  response.current_state.id = 3;
  response.current_state.label = "active";
  return response;
}

Bytes written(const CallHeader& header, const Response& response) {
  Bytes bytes(call_size(Response::message_type(), &response));
  write_call(header, Response::message_type(), &response, bytes.data());
  return bytes;
}

TEST(ServiceCall, of_every_call_that_was_recorded_is_written_back_as_it_was) {
  msgs::TypeLibrary library({test::message_libraries()});
  std::size_t requests = 0, replies = 0;
  for (const std::string recording : {"lc", "act"}) {
    for (const auto& sample : recorded::samples(recording)) {
      const WireKind kind = ros_name(sample.topic).kind;
      if (kind != WireKind::Request && kind != WireKind::Reply) continue;
      (kind == WireKind::Request ? requests : replies) += 1;
      const auto type = library.message(ros_type_name(sample.type).value());
      ASSERT_TRUE(type) << sample.type;
      msgs::AnyMessage message(**type);
      Bytes scratch;
      const auto call = read_call(sample.payload, scratch);
      ASSERT_TRUE(call) << sample.topic;
      EXPECT_GT(call->header.sequence, 0);
      ASSERT_TRUE((*type)->decode(call->message, message.get())) << sample.topic;

      Bytes again(call_size(**type, message.get()));
      write_call(call->header, **type, message.get(), again.data());
      EXPECT_TRUE(recorded::is_padded(sample.payload, again)) << sample.topic << ": " << to_hex(again);
    }
  }
  EXPECT_EQ(requests, 10U);
  EXPECT_EQ(replies, 10U);
}

TEST(ServiceCall, of_a_reply_has_the_header_of_its_request) {
  std::size_t answered = 0;
  for (const std::string recording : {"lc", "act"}) {
    std::vector<CallHeader> asked;
    for (const auto& sample : recorded::samples(recording)) {
      const WireKind kind = ros_name(sample.topic).kind;
      if (kind != WireKind::Request && kind != WireKind::Reply) continue;
      Bytes scratch;
      const CallHeader header = read_call(sample.payload, scratch)->header;
      if (kind == WireKind::Request) asked.push_back(header);
      if (kind == WireKind::Reply && std::count(asked.begin(), asked.end(), header) > 0) ++answered;
    }
  }
  EXPECT_EQ(answered, 8U) << "of ten; the requests of two were not captured";
}

TEST(ServiceCall, has_the_bytes_that_rmw_cyclonedds_writes) {
  EXPECT_EQ(to_hex(written({0x1122334455667788, 1}, active())),
            "00010000"
            "8877665544332211"
            "0100000000000000"
            "03000000"
            "07000000"
            "61637469766500");
}

TEST(ServiceCall, of_a_big_endian_peer_is_read_too) {
  const Bytes bytes = recorded::bytes(
      "00000000"
      "1122334455667788"
      "0000000000000001"
      "03000000"
      "00000007"
      "61637469766500");
  Bytes scratch;
  const auto call = read_call(bytes, scratch);
  ASSERT_TRUE(call);
  EXPECT_EQ(call->header, (CallHeader{0x1122334455667788, 1}));
  Response response;
  ASSERT_TRUE(msgs::from_cdr(call->message, response));
  EXPECT_EQ(response, active());
}

TEST(ServiceCall, is_read_in_place_as_with_a_copy) {
  const Bytes bytes = written({7, -1}, active());
  Bytes own = bytes, scratch;
  const auto copied = read_call(bytes, scratch);
  const auto in_place = read_call_in_place(own);

  ASSERT_TRUE(copied && in_place);
  EXPECT_EQ(copied->header, (CallHeader{7, -1}));
  EXPECT_EQ(in_place->header, copied->header);
  EXPECT_TRUE(
      std::equal(in_place->message.begin(), in_place->message.end(), copied->message.begin(), copied->message.end()));
  EXPECT_EQ(in_place->message.data(), own.data() + kCallHeaderBytes);
}

TEST(ServiceCall, that_is_too_short_or_of_an_unknown_encoding_is_refused) {
  Bytes scratch;
  Bytes bytes = written({7, 1}, active());
  EXPECT_EQ(read_call(ByteView(bytes).first(19), scratch).error(), msgs::DecodeFault::Truncated);
  EXPECT_EQ(read_call({}, scratch).error(), msgs::DecodeFault::Truncated);
  EXPECT_TRUE(read_call(ByteView(bytes).first(20), scratch)) << "whether the body is whole is for the decoder to say";
  bytes[1] = 7;  // XCDR2
  EXPECT_EQ(read_call(bytes, scratch).error(), msgs::DecodeFault::UnknownEncoding);
  EXPECT_EQ(read_call_in_place(bytes).error(), msgs::DecodeFault::UnknownEncoding);
}

TEST(ServiceCall, of_another_client_is_not_ours) {
  EXPECT_TRUE(is_reply_to({42, 1}, 42));
  EXPECT_FALSE(is_reply_to({43, 1}, 42));
}

TEST(Reply, waits_for_the_reader_of_the_client_that_asked) {
  const std::string client = " 1.10.a", none;
  const std::vector<std::string> others{"", " 1.10.b"}, ours{" 1.10.b", " 1.10.a"};

  EXPECT_EQ(reply_step(&client, others, 0ms), ReplyStep::Wait);
  EXPECT_EQ(reply_step(&client, others, 99ms), ReplyStep::Wait);
  EXPECT_EQ(reply_step(&client, others, 100ms), ReplyStep::GiveUp);
  EXPECT_EQ(reply_step(&client, ours, 0ms), ReplyStep::Send);
  EXPECT_EQ(reply_step(&client, ours, 500ms), ReplyStep::Send);
  EXPECT_EQ(reply_step(&none, {}, 0ms), ReplyStep::Send) << "a client that names itself not is not waited for";
  EXPECT_EQ(reply_step(nullptr, ours, 0ms), ReplyStep::Drop) << "the client has gone";
}

TEST(Service, has_the_qos_that_was_recorded) {
  std::set<std::int32_t> depths;
  for (const std::string recording : {"lifecycle", "action"}) {
    for (const auto& endpoint : recorded::endpoints(recording)) {
      const WireKind kind = ros_name(endpoint.topic).kind;
      if (kind != WireKind::Request && kind != WireKind::Reply) continue;
      const std::string half = ros_type_name(endpoint.type).value();
      const DdsQos qos = service_qos(service_of_half(half).value());
      EXPECT_EQ(qos, endpoint.qos) << endpoint.topic << ": depth " << qos.depth;
      depths.insert(qos.depth);
    }
  }
  EXPECT_EQ(depths, (std::set<std::int32_t>{10, 1000}));
  EXPECT_EQ(service_qos("composition_interfaces/srv/LoadNode").depth, 200);
  EXPECT_EQ(service_qos("composition_interfaces/srv/ListNodes").depth, 10);
  EXPECT_EQ(service_qos("").depth, 10);
}

TEST(Service, of_another_middleware_is_known_by_its_user_data) {
  EXPECT_FALSE(has_other_protocol({"RIHS01_x", " 1.10.a", ""})) << "a client of rmw_cyclonedds";
  EXPECT_FALSE(has_other_protocol({"RIHS01_x", "", " 1.10.a"})) << "and its server";
  EXPECT_TRUE(has_other_protocol({"RIHS01_x", "", ""})) << "rmw_fastrtps";
  EXPECT_FALSE(has_other_protocol({"", "", ""})) << "no ROS 2";
}

TEST(Service, is_available_once_both_ends_of_one_server_are_matched) {
  using Ids = std::vector<std::string>;
  EXPECT_FALSE(is_service_available(Ids{}, Ids{}));
  EXPECT_TRUE(is_service_available(Ids{"s1"}, Ids{"s1"}));
  EXPECT_FALSE(is_service_available(Ids{"s1"}, Ids{"s2"})) << "halves of two servers";
  EXPECT_FALSE(is_service_available(Ids{"s1"}, Ids{}));
  EXPECT_FALSE(is_service_available(Ids{"s1"}, Ids{""}));
  EXPECT_TRUE(is_service_available(Ids{"", "s2"}, Ids{"s1", "s2"}));
  EXPECT_TRUE(is_service_available(Ids{""}, Ids{""})) << "a server that names itself not";
  EXPECT_TRUE(is_service_available(Ids{""}, Ids{"s1"}));
  EXPECT_FALSE(is_service_available(Ids{""}, Ids{}));
}

}  // namespace
}  // namespace nacelle::transport_dds
