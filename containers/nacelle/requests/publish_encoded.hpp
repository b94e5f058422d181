// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/bytes.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::requests {

/// Publishes a message that a client of the socket has sent as CDR. Null, or why it was not published.
/// Threads: the writer's. Allocates: what the message's own fields need.
[[nodiscard]] const char* publish_encoded(Writer& writer, const msgs::MessageType& type, ByteView cdr);

}  // namespace nacelle::requests
