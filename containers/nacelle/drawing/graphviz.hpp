// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::drawing {

/// Returns a text as a quoted identifier of the DOT language. Pure.
[[nodiscard]] std::string dot_quoted(const std::string& text);
/// Returns a text as it stands in an HTML-like label of the DOT language. Pure.
[[nodiscard]] std::string dot_label_text(const std::string& text);

/// Returns the format that a file's name asks Graphviz for: "svg", "pdf", "png", "dot"; nothing for another ending. Pure.
[[nodiscard]] std::optional<std::string> drawing_format(const std::string& path);

/// Writes a drawing in the format that the file's name asks for; Graphviz's `dot` lays it out.
///
/// Without `dot` in PATH, the DOT text is written beside, as FILE.dot. Returns then what to tell the user: how to draw it; else an
/// empty text. A file of that name is replaced when the new one is complete.
/// Errors: a file that cannot be written; `dot` failed, with its own words. Threads: any; blocks while `dot` works.
[[nodiscard]] Result<std::string, Problem> write_drawing(const std::string& path, const std::string& dot_text);

}  // namespace nacelle::drawing
