// SPDX-License-Identifier: Apache-2.0
#include "remote/byte_message.hpp"

#include <algorithm>
#include <memory>
#include <new>
#include <utility>

namespace nacelle::remote {
namespace {

Bytes& bytes_of(void* message) { return *static_cast<Bytes*>(message); }
const Bytes& bytes_of(const void* message) { return *static_cast<const Bytes*>(message); }

Result<void, msgs::DecodeFault> read(ByteView bytes, void* message) {
  try {
    bytes_of(message).assign(bytes.begin(), bytes.end());
  } catch (const std::bad_alloc&) { return err(msgs::DecodeFault::OutOfMemory); }
  return {};
}

msgs::MessageType type_named(const char* name, const char* dds_name, const char* hash) {
  return {.name = name,
          .dds_name = dds_name,
          .hash = hash,
          .definition = "",
          .size = sizeof(Bytes),
          .alignment = alignof(Bytes),
          .construct = [](void* memory) { new (memory) Bytes; },
          .destroy = [](void* message) noexcept { std::destroy_at(&bytes_of(message)); },
          .copy_assign = [](void* to, const void* from) { bytes_of(to) = bytes_of(from); },
          .move_assign = [](void* to, void* from) { bytes_of(to) = std::move(bytes_of(from)); },
          .recycle = [](void*) noexcept {},
          .poison = [](void*) {},
          .encoded_size = [](const void* message) { return bytes_of(message).size(); },
          .encode = [](const void* message,
                       std::uint8_t* out) { std::copy(bytes_of(message).begin(), bytes_of(message).end(), out); },
          .decode = read,
          .fields = {},
          .steps = {},
          .least_encoded_size = 0,
          .holds_buffers = false};
}

}  // namespace

ByteMessageType::ByteMessageType(std::string name, std::string dds_name, std::string hash)
    : name_(std::move(name)),
      dds_name_(std::move(dds_name)),
      hash_(std::move(hash)),
      type_(type_named(name_.c_str(), dds_name_.c_str(), hash_.c_str())) {}

}  // namespace nacelle::remote
