// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace nacelle::io {

/// Returns the first line of a file of sysfs; nothing if it cannot be read.
[[nodiscard]] std::optional<std::string> read_attribute(const std::string& path);
/// Writes to a file of sysfs that is there. Returns 0, or errno.
[[nodiscard]] int write_attribute(const std::string& path, std::string_view text);

}  // namespace nacelle::io
