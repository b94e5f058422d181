// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nacelle/node/container_facts.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::session {

/// Returns the parameters of all components as a parameter file, as `nacelle param dump` prints those of one. Of a
/// component in a process of its own it has those that it was given. Threads: any.
[[nodiscard]] RunText parameters_text(const runtime::Container& container);

/// Returns a file that was read for the launch file `main`: its name is its path from there, or the whole path of a file
/// that is elsewhere.
[[nodiscard]] RunText file_text(const std::string& main, const std::string& path, std::string text);

}  // namespace nacelle::session
