// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::msgs {

/// A message type without a definition on this machine. Its messages are the received bytes, with encapsulation and
/// padding, and it has no fields.
///
/// Must outlive everything that refers to its type().
class ByteMessageType {
 public:
  /// Takes the names that the other side announces. `hash` and `definition` may be empty.
  ByteMessageType(std::string name, std::string dds_name, std::string hash, std::string definition = {});
  ByteMessageType(const ByteMessageType&) = delete;
  ByteMessageType& operator=(const ByteMessageType&) = delete;
  ~ByteMessageType() = default;

  [[nodiscard]] const MessageType& type() const { return type_; }

 private:
  const std::string name_, dds_name_, hash_, definition_;
  const MessageType type_;
};

/// Returns whether this is the type() of a ByteMessageType.
[[nodiscard]] bool is_byte_type(const MessageType& type);

/// Returns the byte type with these texts; equal texts give the same one. It lives until the process ends, as other message types do. Null: there
/// are 1000 already, since the names are chosen by other programs.
/// Threads: any.
[[nodiscard]] const MessageType* lasting_byte_type(const std::string& name, const std::string& dds_name,
                                                   const std::string& hash, const std::string& definition);

}  // namespace nacelle::msgs
