// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::remote {

/// A message type without a definition here: its messages are the received bytes, with encapsulation and padding.
///
/// It has no fields. Ownership: outlives everything that knows its type().
class ByteMessageType {
 public:
  /// As the other side has them; `hash` may be empty.
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
