// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/bytes.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::requests {

/// Publishes a message that a client of the socket has sent as CDR. Returns null, or the reason for the refusal.
/// Threads: the writer's. Allocates: memory for the message's own fields.
[[nodiscard]] const char* publish_encoded(Writer& writer, const msgs::MessageType& type, ByteView cdr);

}  // namespace nacelle::requests
