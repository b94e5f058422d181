// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace nacelle::text {

/// Returns a message, given as JSON, as one line of `ros2 topic echo --csv` without a line end: its values in the order
/// of the definition, nested ones included, separated by commas.
///
/// `longest`: further elements of a list and bytes of a text are replaced by "..."; 0: no limit. As in ros2, a text
/// with a comma is not quoted. NaN and infinite numbers are NaN, Infinity and -Infinity. Invalid JSON gives an empty
/// line.
[[nodiscard]] std::string csv_of_json(std::string_view json, std::size_t longest);

}  // namespace nacelle::text
