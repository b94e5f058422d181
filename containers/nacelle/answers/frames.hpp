// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nacelle_interfaces/srv/get_frames.hpp>
#include <nacelle_interfaces/srv/lookup_transform.hpp>
#include <string>

#include "nacelle/base/time.hpp"
#include "nacelle/host/message.hpp"
#include "nacelle/launch/namespace_plan.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::answers {

/// Returns every edge of the frame tree with its owner, rate and age, and the launch file's `names`. Threads: any.
[[nodiscard]] nacelle_interfaces::srv::GetFrames::Response frames_of(const runtime::Container& container,
                                                                     const launch::NamespacePlan& names);
/// Returns the latest transform, or the reason why it is missing. Threads: any.
[[nodiscard]] nacelle_interfaces::srv::LookupTransform::Response transform_of(
    const runtime::Container& container, const nacelle_interfaces::srv::LookupTransform::Request& request);

}  // namespace nacelle::answers
