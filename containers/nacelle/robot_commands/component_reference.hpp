// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::cli {

/// `nacelle component info --doc`: what an installed class declares, or each of them if `plugin` is empty, as Markdown or JSON. Needs no
/// container, and configures nothing. Returns the exit code.
int component_reference(const std::string& plugin, bool as_json);

}  // namespace nacelle::cli
