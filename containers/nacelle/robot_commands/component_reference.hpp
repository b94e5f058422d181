// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::cli {

/// Runs `nacelle component info --doc`. Prints as Markdown or JSON what an installed class declares; for an empty
/// `plugin`, what each installed class declares. Needs no container, and configures no component. Returns the exit
/// code.
int component_reference(const std::string& plugin, bool as_json);

}  // namespace nacelle::cli
