// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace nacelle::reference {

/// Returns a section of Markdown about a class, made of the result of declarations_of(). Pure.
[[nodiscard]] std::string markdown_of(const nlohmann::json& declarations);

}  // namespace nacelle::reference
