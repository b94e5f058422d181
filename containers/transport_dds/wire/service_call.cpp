// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/service_call.hpp"

#include <algorithm>
#include <cstring>
#include <initializer_list>

namespace nacelle::transport_dds {
namespace {

constexpr std::size_t kBodyOffset = msgs::kEncapsulationSize + kCallHeaderBytes;

std::uint64_t load_u64(const std::uint8_t* at, bool little_endian) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof value; ++i) value = value << 8 | at[little_endian ? sizeof value - 1 - i : i];
  return value;
}

void store_le64(std::uint8_t* at, std::uint64_t value) {
  for (std::size_t i = 0; i < sizeof value; ++i) at[i] = static_cast<std::uint8_t>(value >> 8 * i);
}

Result<CallHeader, msgs::DecodeFault> read_header(ByteView payload) {
  if (payload.size() < kBodyOffset) return err(msgs::DecodeFault::Truncated);
  if (payload[0] != 0 || payload[1] > 1) return err(msgs::DecodeFault::UnknownEncoding);
  const bool little_endian = payload[1] == 1;
  const std::uint8_t* const at = payload.data() + msgs::kEncapsulationSize;
  return CallHeader{load_u64(at, little_endian), static_cast<std::int64_t>(load_u64(at + 8, little_endian))};
}

}  // namespace

std::size_t call_size(const msgs::MessageType& type, const void* message) {
  return type.encoded_size(message) + kCallHeaderBytes;
}

void write_call(const CallHeader& header, const msgs::MessageType& type, const void* message, std::uint8_t* out) {
  // The message brings an encapsulation of its own; its place is the header's end, which is written afterwards.
  type.encode(message, out + kCallHeaderBytes);
  std::memcpy(out, out + kCallHeaderBytes, msgs::kEncapsulationSize);
  store_le64(out + msgs::kEncapsulationSize, header.client);
  store_le64(out + msgs::kEncapsulationSize + 8, static_cast<std::uint64_t>(header.sequence));
}

Result<Call, msgs::DecodeFault> read_call(ByteView payload, Bytes& scratch) {
  const auto header = read_header(payload);
  if (!header) return err(header.error());
  scratch.assign(payload.begin() + kCallHeaderBytes, payload.end());
  std::copy_n(payload.begin(), msgs::kEncapsulationSize, scratch.begin());
  return Call{*header, scratch};
}

Result<Call, msgs::DecodeFault> read_call_in_place(ByteSpan payload) {
  const auto header = read_header(payload);
  if (!header) return err(header.error());
  const ByteSpan message = payload.subspan(kCallHeaderBytes);
  std::copy_n(payload.begin(), msgs::kEncapsulationSize, message.begin());
  return Call{*header, message};
}

DdsQos service_qos(std::string_view service_type) {
  DdsQos qos;
  qos.depth = 10;
  const auto slash = service_type.rfind('/');
  const std::string_view package = service_type.substr(0, service_type.find('/'));
  const std::string_view name = slash == std::string_view::npos ? "" : service_type.substr(slash + 1);
  const auto is_one_of = [&](std::initializer_list<std::string_view> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  if (package == "rcl_interfaces" && is_one_of({"DescribeParameters", "GetParameters", "GetParameterTypes",
                                                "ListParameters", "SetParameters", "SetParametersAtomically"})) {
    qos.depth = 1000;
  } else if (package == "composition_interfaces" && is_one_of({"LoadNode", "UnloadNode"})) {
    qos.depth = 200;
  }
  return qos;
}

ReplyStep reply_step(const std::string* request_writer, std::span<const std::string> reply_readers, Duration waited) {
  if (request_writer == nullptr) return ReplyStep::Drop;
  const bool reader_is_here = request_writer->empty() || std::find(reply_readers.begin(), reply_readers.end(),
                                                                   *request_writer) != reply_readers.end();
  if (reader_is_here) return ReplyStep::Send;
  return waited < kReplyPatience ? ReplyStep::Wait : ReplyStep::GiveUp;
}

bool is_service_available(std::span<const std::string> request_readers, std::span<const std::string> reply_writers) {
  const auto names_itself = [](const std::string& id) { return !id.empty(); };
  if (std::none_of(request_readers.begin(), request_readers.end(), names_itself)) {
    return !request_readers.empty() && !reply_writers.empty();
  }
  return std::any_of(reply_writers.begin(), reply_writers.end(), [&](const std::string& id) {
    return !id.empty() && std::find(request_readers.begin(), request_readers.end(), id) != request_readers.end();
  });
}

}  // namespace nacelle::transport_dds
