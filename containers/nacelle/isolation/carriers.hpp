// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/transport_local/carrier.hpp"

namespace nacelle::isolation {

/// Returns the names of the carriers of this build: "iceoryx", or none.
[[nodiscard]] const std::vector<std::string>& carrier_names();
/// Starts a carrier. Errors: an unknown name; a carrier that cannot start (no daemon). The caller then uses the link's
/// socket for streams.
[[nodiscard]] Result<std::unique_ptr<Carrier>, Problem> start_carrier(const std::string& name);

}  // namespace nacelle::isolation
