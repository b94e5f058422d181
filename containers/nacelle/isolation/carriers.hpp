// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/transport_local/carrier.hpp"

namespace nacelle::isolation {

/// The carriers of this build, by name: "iceoryx", or none.
[[nodiscard]] const std::vector<std::string>& carrier_names();
/// Errors: no such name, or one that cannot be used here and now (no daemon); streams go over the link's socket then.
[[nodiscard]] Result<std::unique_ptr<Carrier>, Problem> start_carrier(const std::string& name);

}  // namespace nacelle::isolation
