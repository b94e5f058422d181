// SPDX-License-Identifier: Apache-2.0
#include "requests/publish_encoded.hpp"

namespace nacelle::requests {

const char* publish_encoded(Writer& writer, const msgs::MessageType& type, ByteView cdr) {
  Block* const block = writer.borrow();
  if (block == nullptr) return "no message is free: the readers hold them all";
  if (auto decoded = type.decode(cdr, block->message); !decoded) {
    drop_reference(*block);
    return msgs::explain(decoded.error());
  }
  static_cast<void>(writer.publish(*block));
  return nullptr;
}

}  // namespace nacelle::requests
