// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::runtime {

/// The library of this type stays for the life of the process, also when the component that brought it is unloaded: types, pools,
/// queued messages and the threads of links to other processes refer to it (design D4). Threads: any; hold no lock.
void pin_library_of(const msgs::MessageType& type);

}  // namespace nacelle::runtime
