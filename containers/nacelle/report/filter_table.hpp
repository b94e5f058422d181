// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace nacelle::report {

/// Returns the answer of ask::list_filters() as a table for users: an input's counters in its first row, then one row for each of its
/// axes, and below the table one sentence for each input that needs a look. `width`: as TextTable::text(). Pure.
[[nodiscard]] std::string filters_text(const nlohmann::json& filters, std::size_t width = 0);

}  // namespace nacelle::report
