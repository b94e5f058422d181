// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "cli/whom.hpp"

namespace nacelle::cli {

/// `nacelle component info`: of a Nacelle container, or of another one as far as its nodes tell. Returns the exit code.
int component_info(const Whom& whom, const std::string& name, bool as_json);

}  // namespace nacelle::cli
