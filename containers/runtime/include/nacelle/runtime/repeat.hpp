// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/time.hpp"
#include "nacelle/host/transport.hpp"

namespace nacelle::runtime {

/// Publishes a message that repeats one of another writer from `source_time`: readers see that time. Otherwise like
/// Writer::publish(). `writer` must be made by Container::transport(). Threads: the writer's.
PublishResult repeat(Writer& writer, Block& block, MonotonicTime source_time);

}  // namespace nacelle::runtime
