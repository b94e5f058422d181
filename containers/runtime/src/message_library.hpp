// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::runtime {

/// Keeps the library of this type loaded for the life of the process, also if the component that loaded it is unloaded:
/// types, pools, queued messages and the threads of links to other processes refer to it (design D4). Threads: any;
/// call it without a lock held.
void pin_library_of(const msgs::MessageType& type);

}  // namespace nacelle::runtime
