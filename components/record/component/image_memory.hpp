// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::record {

/// Returns whether it is a type of camera images, of which recording each is a copy.
[[nodiscard]] bool is_image(const msgs::MessageType& type);

/// Returns whether bytes of the message lie in memory that was lent to it (Buffer::adopt), as those of a camera's driver do.
[[nodiscard]] bool is_lent(const msgs::MessageType& type, const void* message);

}  // namespace nacelle::record
