// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/msgs/cdr.hpp"
#include "nacelle/msgs/reflection.hpp"

#include <cstddef>
#include <cstdint>
#include <span>

namespace nacelle::msgs {

/// Everything the runtime, the transports, the recorder and the command line need to know of a message type.
///
/// There is one per type, in the read-only data of the message package's library; it lives as long as the library is
/// loaded. `T::message_type()` answers it.
/// Threads: constant; the functions are as safe as the message they are given.
struct MessageType {
  const char* name;        ///< "sensor_msgs/msg/Image"
  const char* dds_name;    ///< "sensor_msgs::msg::dds_::Image_"
  const char* hash;        ///< "RIHS01_" and 64 hexadecimal digits
  const char* definition;  ///< The .msg text followed by those of its dependencies, in ros2msg's form, for recorders.
  std::size_t size;
  std::size_t alignment;

  void (*construct)(void* memory);  ///< Gives every field its default.
  void (*destroy)(void* message) noexcept;
  void (*copy_assign)(void* to, const void* from);
  void (*move_assign)(void* to, void* from);
  /// Makes a message ready for its next use: foreign Buffers everywhere in it go back to their owners; values and the
  /// message's own capacity stay.
  void (*recycle)(void* message) noexcept;
  /// Overwrites numbers (NaN, 0xCD...) in the message and its fixed parts; texts and sequences stay. For debug builds.
  void (*poison)(void* message);

  std::size_t (*encoded_size)(const void* message);                    ///< See nacelle::msgs::encoded_size().
  void (*encode)(const void* message, std::uint8_t* out);              ///< See nacelle::msgs::encode().
  Result<void, DecodeFault> (*decode)(ByteView bytes, void* message);  ///< See nacelle::msgs::decode().

  std::span<const Field>
      fields;  ///< In the definition's order. Empty for an empty message, which is one byte on the wire.
  std::span<const Step> steps;     ///< The encoding's plan.
  std::size_t least_encoded_size;  ///< No body of this type is shorter, whatever its alignment.
  bool holds_buffers;              ///< recycle() has work to do.
};

/// `S::service_type()`.
struct ServiceType {
  const char* name;  ///< "std_srvs/srv/SetBool"
  const char* hash;
  const char* definition;  ///< The .srv text and its dependencies.
  MessageTypeFunction request;
  MessageTypeFunction response;
  MessageTypeFunction event;
};
using ServiceTypeFunction = const ServiceType& (*)();

/// `A::action_type()`.
struct ActionType {
  const char* name;  ///< "nav2_msgs/action/NavigateToPose"
  const char* hash;
  const char* definition;  ///< The .action text and its dependencies.
  MessageTypeFunction goal;
  MessageTypeFunction result;
  MessageTypeFunction feedback;
  ServiceTypeFunction send_goal;
  ServiceTypeFunction get_result;
  MessageTypeFunction feedback_message;
};
using ActionTypeFunction = const ActionType& (*)();

/// What a message package's library holds; derived types (_Request, _SendGoal, ...) are in the lists too.
struct PackageTable {
  const char* package;
  std::span<const MessageTypeFunction> messages;
  std::span<const ServiceTypeFunction> services;
  std::span<const ActionTypeFunction> actions;
};

/// The name and the type of the one symbol by which a message package's library is entered.
inline constexpr const char* kPackageEntry = "nacelle_message_package_v1";
using PackageEntry = const PackageTable* (*)();

/// The bytes of a message; for tests and tools (a publisher encodes into memory it keeps).
template <typename Message>
[[nodiscard]] Bytes to_cdr(const Message& message) {
  Bytes bytes(encoded_size(Message::message_type(), &message));
  encode(Message::message_type(), &message, bytes.data());
  return bytes;
}
/// Reads bytes into `message`.
template <typename Message>
[[nodiscard]] Result<void, DecodeFault> from_cdr(ByteView bytes, Message& message) {
  return decode(Message::message_type(), bytes, &message);
}

}  // namespace nacelle::msgs
