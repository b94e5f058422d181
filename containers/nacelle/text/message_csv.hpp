// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace nacelle::text {

/// A message that is written as JSON as one line of `ros2 topic echo --csv`: its values in the definition's order with commas
/// between them, whatever they are nested in, without a line's end.
///
/// `longest`: elements of a list and characters of a text beyond so many are "..."; 0: none are. A text with a comma is not
/// quoted, as with ros2. NaN and infinite numbers are NaN, Infinity and -Infinity. What is no JSON gives an empty line.
[[nodiscard]] std::string csv_of_json(std::string_view json, std::size_t longest);

}  // namespace nacelle::text
