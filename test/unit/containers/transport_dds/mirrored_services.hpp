// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <example_interfaces/srv/add_two_ints.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "mirrored_container.hpp"

namespace nacelle::test {

using example_interfaces::srv::AddTwoInts;

inline AddTwoInts::Request request_of(std::int64_t a, std::int64_t b) {
  AddTwoInts::Request request;
  request.a = a;
  request.b = b;
  return request;
}
inline AddTwoInts::Response response_of(std::int64_t sum) {
  AddTwoInts::Response response;
  response.sum = sum;
  return response;
}
inline void add(const AddTwoInts::Request& request, AddTwoInts::Response& response) {
  response.sum = request.a + request.b;
}

inline std::unique_ptr<RawEnd> raw_client(transport_dds::Participant& participant, const std::string& id = {},
                                          std::optional<std::string> hash = {}) {
  return std::make_unique<RawEnd>(participant, AddTwoInts::Request::message_type(),
                                  AddTwoInts::Response::message_type(), "/add", false, id, std::move(hash));
}
inline std::unique_ptr<RawEnd> raw_server(transport_dds::Participant& participant, const std::string& id = {},
                                          std::optional<std::string> hash = {}) {
  return std::make_unique<RawEnd>(participant, AddTwoInts::Request::message_type(),
                                  AddTwoInts::Response::message_type(), "/add", true, id, std::move(hash));
}

/// The header and the sum of a reply.
inline std::pair<transport_dds::CallHeader, std::int64_t> read_reply(const Bytes& bytes) {
  Bytes scratch;
  const auto call = transport_dds::read_call(bytes, scratch);
  AddTwoInts::Response response;
  if (!call || !msgs::from_cdr(call->message, response)) return {{}, -1};
  return {call->header, response.sum};
}

/// A caller here and a server there, which only the network joins.
class MirrorServices : public ::testing::Test {
 public:
  template <typename F>
  [[nodiscard]] bool until(F holds) {
    return here.bell.until(holds);
  }
  /// The caller here and the server there know each other, on both sides.
  [[nodiscard]] bool joined() {
    return until([&] {
      std::size_t ends = 0;
      there.mirror->look([&](const transport_dds::RemoteGraph& graph) { ends = graph.ends_of_service("/add").size(); });
      return ends != 0 && ends % 2 == 0 && calling.client->service_is_ready();
    });
  }

  // What the components consist of, before the containers.
  Offering<AddTwoInts> adding{"/add", add};
  Pondering<AddTwoInts> pondering{"/add"};
  Calling<AddTwoInts> calling{"/add"}, other{"/add"};
  MirroredContainer here{"here"}, there{"there"};
};

}  // namespace nacelle::test
