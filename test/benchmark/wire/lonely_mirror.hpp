// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nacelle/transport_dds/mirror.hpp"

namespace nacelle::bench {

/// A mirror on a loopback interface without other participants; returns when it has announced itself. Errors: the
/// program ends with the words and code 1.
[[nodiscard]] std::unique_ptr<DdsMirror> start_lonely_mirror(nacelle::Graph& graph, const Clock& clock,
                                                             ServiceGraph* services = nullptr);

}  // namespace nacelle::bench
