// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "cli/whom.hpp"

namespace nacelle::cli {

/// Runs `nacelle component info`. For a container that is not Nacelle's, prints what its nodes report. Returns the exit
/// code.
int component_info(const Whom& whom, const std::string& name, bool as_json);

}  // namespace nacelle::cli
