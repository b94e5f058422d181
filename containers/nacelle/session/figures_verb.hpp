// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace nacelle::session {

class Session;

/// Answers "figures": every counter of streams, readers, callbacks, components and threads, and of the processes of components
/// with `isolate: process`. All are totals since the start; whoever wants rates asks twice (`now_ns`).
/// Threads: the main thread.
[[nodiscard]] nlohmann::json figures_of(Session& session);

}  // namespace nacelle::session
