// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nacelle_interfaces/srv/get_component.hpp>
#include <string>

#include "nacelle/runtime/container.hpp"

namespace nacelle::answers {

/// Returns the details of a component: its origin, the settings that it was loaded with, how it runs, its faults.
/// `name`: as Container::find(). Threads: any.
[[nodiscard]] nacelle_interfaces::srv::GetComponent::Response details_of(const runtime::Container& container,
                                                                         const std::string& name);

}  // namespace nacelle::answers
