// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "nacelle/base/problem.hpp"
#include "record/protocol/mcap_fault.hpp"

namespace nacelle::cli {

/// Returns the problem as it is printed: the file, the place in it, and what can be done.
[[nodiscard]] Problem problem_of(const std::string& file, const record::McapProblem& problem);

/// "1.2 MiB", as ros2 prints sizes.
[[nodiscard]] std::string size_text(std::uint64_t bytes);

}  // namespace nacelle::cli
