// SPDX-License-Identifier: Apache-2.0
// Names, USER_DATA, calls and snapshots from the network: what is accepted is well-formed and goes back to the same
// bytes.
#include <algorithm>

#include "nacelle/base/expect.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "transport_dds/wire/graph_snapshot.hpp"
#include "transport_dds/wire/names.hpp"
#include "transport_dds/wire/service_call.hpp"
#include "transport_dds/wire/user_data.hpp"

namespace {

using namespace nacelle;
using namespace nacelle::transport_dds;

void read_names(std::string_view text) {
  const RosName name = ros_name(text);
  const auto is_again = [&](const Result<std::string, Problem>& dds) { return dds.has_value() && *dds == text; };
  switch (name.kind) {
    case WireKind::Topic: NACELLE_EXPECT(is_again(dds_topic_name(name.name)), "a topic goes there and back"); break;
    case WireKind::Request:
      NACELLE_EXPECT(is_again(dds_request_name(name.name)), "a request goes there and back");
      break;
    case WireKind::Reply: NACELLE_EXPECT(is_again(dds_reply_name(name.name)), "a reply goes there and back"); break;
    case WireKind::Discovery:
    case WireKind::Foreign: NACELLE_EXPECT(name.name.empty(), "these have no name in ROS 2"); break;
  }
  if (const auto type = ros_type_name(text))
    NACELLE_EXPECT(is_again(dds_type_name(*type)), "a type goes there and back");
  if (const auto type = dds_type_name(text)) NACELLE_EXPECT(ros_type_name(*type) == text, "a type comes back");
}

void read_user_data(ByteView bytes) {
  std::size_t most = bytes.size();
  for (const auto& [key, value] : parse_user_data(bytes)) {
    NACELLE_EXPECT(!key.empty() && !value.empty(), "neither key nor value is empty");
    NACELLE_EXPECT(key.size() + value.size() < most, "nothing is invented");
    most -= key.size() + value.size();
  }
  const EndpointUserData data = read_endpoint_user_data(bytes);
  const bool writable = data.client_id.find(';') == std::string::npos && data.service_id.find(';') == std::string::npos;
  if (writable) NACELLE_EXPECT(read_endpoint_user_data(as_bytes(write_endpoint_user_data(data))) == data, "comes back");
  const auto enclave = read_participant_user_data(bytes);
  if (enclave) NACELLE_EXPECT(!enclave->empty() && enclave->size() <= kMostEnclaveBytes, "bounded");
}

void read_calls(ByteView bytes) {
  Bytes scratch, own(bytes.begin(), bytes.end());
  const auto copied = read_call(bytes, scratch);
  const auto in_place = read_call_in_place(own);
  NACELLE_EXPECT(copied.has_value() == in_place.has_value(), "both ways agree");
  if (!copied) return;
  NACELLE_EXPECT(copied->header == in_place->header, "both ways agree on the header");
  NACELLE_EXPECT(
      std::equal(copied->message.begin(), copied->message.end(), in_place->message.begin(), in_place->message.end()),
      "both ways agree on the body");
  Snapshot body;  // any type will do
  if (!msgs::from_cdr(copied->message, body)) return;
  Bytes again(call_size(Snapshot::message_type(), &body));
  write_call(copied->header, Snapshot::message_type(), &body, again.data());
  Snapshot body_again;
  const auto call = read_call(again, scratch);
  NACELLE_EXPECT(call && call->header == copied->header, "a header comes back");
  NACELLE_EXPECT(msgs::from_cdr(call->message, body_again) && body_again == body, "a body comes back");
}

void read_snapshot(ByteView bytes) {
  Snapshot snapshot, again;
  if (!msgs::from_cdr(bytes, snapshot)) return;
  NACELLE_EXPECT(msgs::from_cdr(msgs::to_cdr(snapshot), again) && again == snapshot, "a snapshot comes back");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const ByteView bytes{data, size};
  read_names(as_text(bytes));
  read_user_data(bytes);
  read_calls(bytes);
  read_snapshot(bytes);
  return 0;
}
