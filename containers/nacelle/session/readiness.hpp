// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::session {

/// "first_message(/scan)", "tf(odom->base_link)"; empty for `active`.
[[nodiscard]] std::string words_of(const launch::AfterCondition& condition);

/// Returns a function that returns what the condition lacks in addition to an active node, or nothing once it holds. An
/// empty function for `active`.
///
/// A first message of any publisher counts: the condition is about the stream. Keeps `container` by reference.
[[nodiscard]] std::function<std::string()> missing_of(const launch::AfterCondition& condition,
                                                      const runtime::Container& container);

}  // namespace nacelle::session
