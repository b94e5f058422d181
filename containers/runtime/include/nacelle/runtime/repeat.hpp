// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/time.hpp"
#include "nacelle/host/transport.hpp"

namespace nacelle::runtime {

/// Publishes a message that repeats what another writer published at `source_time`: readers see that time. The rest is as with
/// Writer::publish(). `writer`: one that Container::transport() has made. Threads: the writer's.
PublishResult repeat(Writer& writer, Block& block, MonotonicTime source_time);

}  // namespace nacelle::runtime
