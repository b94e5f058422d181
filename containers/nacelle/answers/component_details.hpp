// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nacelle_interfaces/srv/get_component.hpp>
#include <string>

#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::answers {

/// Returns what there is to know of a component: where it comes from, what it was loaded with, how it runs, what went wrong.
/// `name`: as Container::find(). Of a component in a process of its own `plan` has what it was loaded with. Threads: any.
[[nodiscard]] nacelle_interfaces::srv::GetComponent::Response details_of(const runtime::Container& container,
                                                                         const launch::Plan& plan,
                                                                         const std::string& name);

}  // namespace nacelle::answers
