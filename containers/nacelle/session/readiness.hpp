// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::session {

/// Returns "first_message(/scan)" or "tf(odom->base_link)"; empty for `active`.
[[nodiscard]] std::string words_of(const launch::AfterCondition& condition);

/// Returns a function for a condition. It returns what the condition still requires besides an active node, or an empty
/// text once the condition holds. The function is empty for `active`.
///
/// A first message of any publisher counts, because the condition is about the stream. The function refers to
/// `container`.
[[nodiscard]] std::function<std::string()> missing_of(const launch::AfterCondition& condition,
                                                      const runtime::Container& container);

}  // namespace nacelle::session
