// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "loading/program_places.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/runtime/plugin_library.hpp"

namespace nacelle::reference {

/// Returns what a component class declares: topics, services, actions, transforms, parameters and devices.
///
/// Constructs the class without parameters, in a container of its own, and does not configure it: no device is opened.
/// Names of topics and services are as the class wrote them: "scan", "~/image_raw", "/tf". If the class names
/// parameters on which others depend (ComponentAbout::also_with), "with_parameters" holds them, and "also" holds what
/// the class declares only with them.
/// Errors: as Container::load(); a value of also_with that is not a parameter.
/// Threads: any; blocks until the constructors return.
[[nodiscard]] Result<nlohmann::json, Problem> declarations_of(const runtime::PluginEntry& plugin,
                                                              const loading::ProgramPlaces& places, const Clock& clock);

}  // namespace nacelle::reference
