// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nacelle_interfaces/srv/get_statistics.hpp>
#include <string>
#include <vector>

#include "nacelle/runtime/container.hpp"

namespace nacelle::answers {

/// Returns every counter of streams, readers, callbacks, components and threads of this process, and of the processes
/// of components with `isolate: process`. Threads: any.
[[nodiscard]] nacelle_interfaces::srv::GetStatistics::Response statistics_of(const runtime::Container& container);

/// Returns the counters of a node's callbacks; for an empty name, of all nodes. Threads: any.
[[nodiscard]] std::vector<nacelle_interfaces::msg::CallbackStatistics> callbacks_of(const runtime::Container& container,
                                                                                    const std::string& node);

}  // namespace nacelle::answers
