// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::remote {

/// A message type without a definition on this machine. Its messages are the received bytes, with encapsulation and
/// padding, and it has no fields.
///
/// Must outlive everything that refers to its type().
class ByteMessageType {
 public:
  /// Takes the names that the other side announces. `hash` may be empty.
  ByteMessageType(std::string name, std::string dds_name, std::string hash);
  ByteMessageType(const ByteMessageType&) = delete;
  ByteMessageType& operator=(const ByteMessageType&) = delete;
  ~ByteMessageType() = default;

  [[nodiscard]] const msgs::MessageType& type() const { return type_; }

 private:
  const std::string name_, dds_name_, hash_;
  const msgs::MessageType type_;
};

}  // namespace nacelle::remote
