// SPDX-License-Identifier: Apache-2.0
#include "nacelle/msgs/byte_message.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <new>
#include <tuple>
#include <utility>

#include "nacelle/base/guarded.hpp"

namespace nacelle::msgs {
namespace {

constexpr std::size_t kMostLasting = 1000;

Bytes& bytes_of(void* message) { return *static_cast<Bytes*>(message); }
const Bytes& bytes_of(const void* message) { return *static_cast<const Bytes*>(message); }

Result<void, DecodeFault> take_bytes(ByteView bytes, void* message) {
  try {
    bytes_of(message).assign(bytes.begin(), bytes.end());
  } catch (const std::bad_alloc&) { return err(DecodeFault::OutOfMemory); }
  return {};
}

MessageType type_named(const char* name, const char* dds_name, const char* hash, const char* definition) {
  return {.name = name,
          .dds_name = dds_name,
          .hash = hash,
          .definition = definition,
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
          .decode = take_bytes,
          .fields = {},
          .steps = {},
          .least_encoded_size = 0,
          .holds_buffers = false};
}

}  // namespace

ByteMessageType::ByteMessageType(std::string name, std::string dds_name, std::string hash, std::string definition)
    : name_(std::move(name)),
      dds_name_(std::move(dds_name)),
      hash_(std::move(hash)),
      definition_(std::move(definition)),
      type_(type_named(name_.c_str(), dds_name_.c_str(), hash_.c_str(), definition_.c_str())) {}

bool is_byte_type(const MessageType& type) { return type.decode == take_bytes; }

const MessageType* lasting_byte_type(const std::string& name, const std::string& dds_name, const std::string& hash,
                                     const std::string& definition) {
  using Texts = std::tuple<std::string, std::string, std::string, std::string>;
  // Never destroyed: threads that end after main() may use a type.
  static auto& all = *new Guarded<std::map<Texts, ByteMessageType>>;
  auto types = all.lock();
  const Texts texts{name, dds_name, hash, definition};
  const auto known = types->find(texts);
  if (known != types->end()) return &known->second.type();
  if (types->size() >= kMostLasting) return nullptr;
  const auto made = types->emplace(std::piecewise_construct, std::forward_as_tuple(texts),
                                   std::forward_as_tuple(name, dds_name, hash, definition));
  return &made.first->second.type();
}

}  // namespace nacelle::msgs
