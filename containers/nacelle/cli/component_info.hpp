// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "whom.hpp"

namespace nacelle::cli {

/// `nacelle component info`: of a container here, or of one on the network as far as nodes tell there. Returns the exit code.
int component_info(const Whom& whom, const std::string& name, bool as_json);

}  // namespace nacelle::cli
